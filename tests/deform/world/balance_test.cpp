/// Worlds whose objects meet with their surfaces: forces, balance, and bodies that meet themselves.

#include "elastic/elastic_methods.hpp"
#include "maille/deform/world/world.hpp"
#include "support/kit.hpp"
#include "support/worlds/worlds.hpp"
#include "world/surface/contact_program.hpp"
#include "world/surface/flexibility.hpp"
#include "world/surface/skin.hpp"

namespace maille::deform {
namespace {

using test::belly_and;
using test::box_object;
using test::drive_of;
using test::elastic_object;
using test::empty_world;
using test::hold_face;

constexpr double skin = 1e-4; ///< that surfaces keep from one another [cells]

WorldScene surfaces(std::initializer_list<int> cells) {
  WorldScene scene = empty_world(cells, "coupled");
  scene.contact = ContactLaw::surfaces;
  return scene;
}

WorldObject bar(const std::string& name, std::initializer_list<int> cells, const Vec3& at, double modulus) {
  WorldObject object = elastic_object(name, cells, at);
  object.scene.materials[0].elasticity = ElasticConstants::isotropic(modulus, 0);
  return object;
}

/// What one object acts on another with.
Eigen::Vector3d force_on(const FrameResult& result, int object, int other) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const WorldContact& contact : result.contacts)
    if (contact.object == object && contact.other == other)
      sum += contact.force;
  return sum;
}

// Oracle: every set of contacts that may press, one by one.
TEST(ContactProgramOracle, FindsTheForcesThatTryingEverySetFinds) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int question = 0; question < 200; ++question) {
    const int n = 1 + int(random() % 7);
    const Eigen::MatrixXd root = Eigen::MatrixXd::NullaryExpr(n, n, [&] { return normal(random); });
    const Eigen::MatrixXd compliance = root * root.transpose() + 0.01 * Eigen::MatrixXd::Identity(n, n);
    const Eigen::VectorXd gap = Eigen::VectorXd::NullaryExpr(n, [&] { return normal(random); });
    std::vector<char> may_pull(static_cast<std::size_t>(n)), active;
    for (char& one : may_pull)
      one = random() % 4 == 0;
    const Eigen::VectorXd found = contact_forces(compliance, gap, may_pull, active);
    bool is_known = false;
    for (unsigned set = 0; set < 1u << n && !is_known; ++set) {
      std::vector<Eigen::Index> chosen;
      for (int i = 0; i < n; ++i)
        if ((set >> i & 1) != 0)
          chosen.push_back(i);
      Eigen::VectorXd force = Eigen::VectorXd::Zero(n);
      if (!chosen.empty())
        force(chosen) = compliance(chosen, chosen).fullPivLu().solve(-gap(chosen));
      const Eigen::VectorXd left = gap + compliance * force;
      bool is_answer = true;
      for (int i = 0; i < n; ++i)
        is_answer = is_answer && (may_pull[std::size_t(i)] != 0 ? std::abs(left[i]) < 1e-9
                                                                : force[i] > -1e-12 && left[i] > -1e-9);
      is_known = is_answer && (force - found).norm() < 1e-8 * (1 + force.norm());
    }
    EXPECT_TRUE(is_known) << "question " << question;
  }
}

/// A soft body of rows of cells in two dimensions, the lowest last.
WorldScene soft_rows(const std::string& rows, const std::string& settings) {
  return parse_world_scene(fmt::format(R"([world]
cells = [40, 40]
spacing = "1 mm"
contact = "surfaces"
[[object]]
name = "body"
kind = "deformable"
shape = "rows"
rows = [{}]
material = {{ youngs_modulus = "10 kPa", poisson_ratio = 0.3 }}
{})",
                                       rows, settings));
}

// Oracle: all faces of the other skin are looked at, for every node. Skins that wander: what is kept of where
// they were before is enough.
TEST(NearFacesOracle, NothingThatIsNearIsMissed) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1, 1);
  const Skin ball(elastic_object("ball", {5, 5, 5}, {}).scene.specimen),
      plate(elastic_object("plate", {8, 8, 1}, {}).scene.specimen);
  const auto places_of = [](const Skin& of, const Grid& grid) {
    std::vector<Eigen::Vector3d> places;
    for (std::int32_t node = 0; node < of.n_nodes(); ++node) {
      const Index3 at = grid.node_at(of.node(node));
      places.emplace_back(at[0], at[1], at[2]);
    }
    return places;
  };
  std::vector<Eigen::Vector3d> of_ball =
                                   places_of(ball, elastic_object("", {5, 5, 5}, {}).scene.specimen.grid),
                               of_plate =
                                   places_of(plate, elastic_object("", {8, 8, 1}, {}).scene.specimen.grid);
  for (Eigen::Vector3d& x : of_ball)
    x += Eigen::Vector3d(1, 1, 1.2);
  NearFaces kept;
  int n_near = 0;
  constexpr double reach = 0.5;
  for (int step = 0; step < 60; ++step) {
    const Eigen::Vector3d way = 0.1 * Eigen::Vector3d(any(random), any(random), any(random));
    for (Eigen::Vector3d& x : of_ball)
      x += way + 0.02 * Eigen::Vector3d(any(random), any(random), any(random));
    kept.update(ball, of_ball, plate, of_plate, reach, 0.5);
    const PlacedSkin placed(plate, of_plate, of_plate, reach);
    std::vector<std::int32_t> all(plate.faces().size());
    std::iota(all.begin(), all.end(), 0);
    std::size_t next = 0;
    for (std::int32_t node = 0; node < ball.n_nodes(); ++node) {
      const Eigen::Vector3d& point = of_ball[std::size_t(node)];
      const auto expected = placed.near(point, all);
      const bool is_known = next < kept.nodes().size() && kept.nodes()[next].node == node;
      const auto found =
          is_known ? placed.near(point, kept.faces(kept.nodes()[next])) : std::vector<PlacedSkin::Near>{};
      next += is_known;
      ASSERT_EQ(found.size(), expected.size()) << "step " << step << ", node " << node;
      for (std::size_t i = 0; i < found.size(); ++i) {
        EXPECT_EQ(found[i].face, expected[i].face);
        EXPECT_EQ(found[i].gap, expected[i].gap);
        EXPECT_EQ(found[i].normal, expected[i].normal);
      }
      n_near += int(found.size());
    }
  }
  EXPECT_GT(n_near, 500);
}

// Oracle: a list that was made from nothing has all that is near, each time. A skin that is dented here and
// there, as contacts do: what has not moved is not looked at again.
TEST(NearFacesOracle, OfADentedSkinNothingThatIsNearIsMissed) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(-1, 1);
  const Specimen body = elastic_object("", {4, 9, 9}, {}).scene.specimen;
  const Skin plate(body);
  std::vector<Eigen::Vector3d> places;
  for (std::int32_t node = 0; node < plate.n_nodes(); ++node) {
    const Index3 at = body.grid.node_at(plate.node(node));
    places.emplace_back(at[0], at[1], at[2]);
  }
  constexpr double reach = 1, margin = 1;
  NearFaces kept;
  std::size_t n_near = 0;
  for (int dent = 0; dent < 40; ++dent) {
    const Eigen::Vector3d middle(2, 4.5 + 4 * any(random), 4.5 + 4 * any(random));
    for (Eigen::Vector3d& x : places) // towards the middle of the plate, and back
      if ((x - middle).tail<2>().norm() < 2)
        x[0] += 0.4 * any(random) * (2 - x[0]);
    kept.update(plate, places, plate, places, reach, margin);
    NearFaces anew;
    anew.update(plate, places, plate, places, reach, 0);
    for (const NearFaces::OfNode& one : anew.nodes()) {
      const auto known = std::ranges::lower_bound(kept.nodes(), one.node, {}, &NearFaces::OfNode::node);
      ASSERT_TRUE(known != kept.nodes().end() && known->node == one.node) << "dent " << dent;
      ASSERT_TRUE(std::ranges::includes(kept.faces(*known), anew.faces(one))) << "dent " << dent;
      n_near += anew.faces(one).size();
    }
  }
  EXPECT_GT(n_near, 500U);
}

// Oracle: cells near a node by hand: of a C the ends of its arms are near one another in space alone.
TEST(NearFacesOracle, OfASkinAndItselfWhatIsFarInTheBodyCounts) {
  const Specimen body = soft_rows(R"("######","#.....","######")", "").objects[0].scene.specimen;
  const Skin of_body(body);
  std::vector<Eigen::Vector3d> places;
  for (std::int32_t node = 0; node < of_body.n_nodes(); ++node) {
    const Index3 at = body.grid.node_at(of_body.node(node));
    places.emplace_back(at[0], at[1], 0);
  }
  NearFaces near;
  near.update(of_body, places, of_body, places, 1.01, 0);
  const PlacedSkin placed(of_body, places, places, 1.01);
  int n_near = 0;
  for (const NearFaces::OfNode& one : near.nodes()) {
    const Index3 at = body.grid.node_at(of_body.node(one.node));
    if (placed.near(places[std::size_t(one.node)], near.faces(one)).empty())
      continue;
    ++n_near;
    EXPECT_TRUE(at[1] == 1 || at[1] == 2) << "only sides that face the gap";
    EXPECT_GE(at[0], 2) << "from the C's back it is two steps to the other side";
  }
  EXPECT_EQ(n_near, 10); // x = 2 to 6 on both sides
}

// Analytic: the conditions of Signorini, of contacts of which each says what five others say, all but for
// rounding: none pulls, no gap is less than 0, and what presses has none.
TEST(ContactProgramAnalytic, ManyContactsMaySayTheSame) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int question = 0; question < 20; ++question) {
    constexpr int different = 30, n = 6 * different;
    const Eigen::MatrixXd root =
        Eigen::MatrixXd::NullaryExpr(different, different, [&] { return normal(random); });
    Eigen::MatrixXd own(n, different);
    Eigen::VectorXd gap(n);
    for (int i = 0; i < n; ++i) {
      own.row(i) = root.row(i % different);
      gap[i] = 0.1 * std::sin(i % different) - 0.05;
    }
    const Eigen::MatrixXd compliance =
        own * own.transpose() + 1e-7 * Eigen::MatrixXd(Eigen::MatrixXd::Identity(n, n));
    std::vector<char> active;
    const Eigen::VectorXd force = contact_forces(compliance, gap, std::vector<char>(n, 0), active);
    const Eigen::VectorXd left = gap + compliance * force;
    EXPECT_GE(force.minCoeff(), 0);
    EXPECT_GT(force.maxCoeff(), 0);
    EXPECT_GT(left.minCoeff(), -1e-9);
    EXPECT_LT(force.cwiseProduct(left).cwiseAbs().maxCoeff(), 1e-9 * force.maxCoeff());
  }
}

/// The skin of a plate of cells in a row along x, its upper side bent over a cylinder.
struct BentPlate {
  static constexpr int n = 12;
  static constexpr double radius = 6, angle = 10 * std::numbers::pi / 180; ///< of a face
  Skin of{elastic_object("plate", {n, 2, 1}, {}).scene.specimen};
  std::vector<Eigen::Vector3d> rest, places;
  std::vector<std::int32_t> all = std::vector<std::int32_t>(of.faces().size()); ///< faces

  BentPlate() {
    std::iota(all.begin(), all.end(), 0);
    const Grid grid = elastic_object("plate", {n, 2, 1}, {}).scene.specimen.grid;
    for (std::int32_t node = 0; node < of.n_nodes(); ++node) {
      const Index3 at = grid.node_at(of.node(node));
      const double turn = (at[0] - 0.5 * n) * angle, from_axis = at[2] == 1 ? radius : radius - 1;
      rest.emplace_back(at[0], at[1], at[2]);
      places.emplace_back(from_axis * std::sin(turn), at[1], from_axis * std::cos(turn));
    }
  }
};

// Analytic: a cylinder's normals are radial; those of its 12 faces are 5 degrees off where they meet, and go
// over into one another. Contract: at the ends of the plate its edges stay edges.
TEST(PlacedSkinAnalytic, NormalsGoOverFromFaceToFace) {
  const BentPlate plate;
  const PlacedSkin placed(plate.of, plate.places, plate.rest, 0.5);
  double worst = 0, before = 0;
  bool is_first = true;
  for (double turn = -0.8; turn < 0.8; turn += 0.01) { // the last face on each side knows no face beyond it
    const Eigen::Vector3d radial(std::sin(turn), 0, std::cos(turn));
    const auto near = placed.near(Eigen::Vector3d(0, 1, 0) + (BentPlate::radius + 0.05) * radial, plate.all);
    ASSERT_EQ(near.size(), 1) << turn;
    worst = std::max(worst, std::acos(std::min(1.0, near[0].normal.dot(radial))));
    const double along = std::atan2(near[0].normal[0], near[0].normal[2]);
    if (!is_first) {
      EXPECT_GT(along, before) << turn; // without a leap
      EXPECT_LT(along - before, 0.02) << turn;
    }
    before = along;
    is_first = false;
    EXPECT_NEAR(near[0].gap, 0.05 + BentPlate::radius * (1 - std::cos(0.5 * BentPlate::angle)) / 2,
                BentPlate::radius * (1 - std::cos(0.5 * BentPlate::angle)) / 2 + 1e-3);
  }
  EXPECT_LT(worst, 0.01); // of 5 degrees, which are 0.087
  const Eigen::Vector3d end = plate.places[std::size_t(plate.of.faces()[0].node[0])];
  for (const auto& near : placed.near(end + Eigen::Vector3d(0, -0.2, 0), plate.all))
    EXPECT_NEAR(near.normal[1], -1, 1e-9); // beside the plate, before its flat side
}

// Analytic: at a fold, however deep, normals go over from the mean of its two faces to that of one.
TEST(PlacedSkinAnalytic, AFoldIsNoEdge) {
  const BentPlate plate;
  for (double slope = -0.9; slope < 0.9; slope += 0.05) { // of the right half
    std::vector<Eigen::Vector3d> folded = plate.rest;
    const Eigen::Vector3d along(std::cos(slope), 0, -std::sin(slope)), normal(std::sin(slope), 0, along[0]);
    for (Eigen::Vector3d& x : folded)
      if (x[0] > 6)
        x = Eigen::Vector3d(6, x[1], 1) + (x[0] - 6) * along + (x[2] - 1) * normal;
    const PlacedSkin placed(plate.of, folded, plate.rest, 0.5);
    const auto near = placed.near(Eigen::Vector3d(6, 1, 1) + 0.25 * along + 0.05 * normal, plate.all);
    ASSERT_EQ(near.size(), 1) << slope;
    const Eigen::Vector3d at_fold = (normal + Eigen::Vector3d::UnitZ()).normalized();
    EXPECT_LT((near[0].normal - (0.75 * at_fold + 0.25 * normal).normalized()).norm(), 1e-9) << slope;
    EXPECT_NEAR(near[0].gap, 0.05, 1e-9);
  }
}

// Analytic: an edge is as wide as a thousandth of the reach. On it the point's own face decides.
TEST(PlacedSkinAnalytic, AnEdgeHasAWidth) {
  const BentPlate plate;
  constexpr double reach = 0.5;
  const PlacedSkin placed(plate.of, plate.rest, plate.rest, reach);
  const auto below = std::ranges::find(plate.rest, Eigen::Vector3d(6, 1, 0)); // inside of the lower side
  for (const auto& [distance, up] : {std::pair(0.6e-3, 1.0), std::pair(1.6e-3, std::sqrt(0.5))}) {
    const Eigen::Vector3d point =
        Eigen::Vector3d(12, 1, 1) + distance * reach * Eigen::Vector3d(1, 0, 1).normalized();
    std::vector<Eigen::Vector3d> above = plate.rest;
    for (Eigen::Vector3d& x : above)
      x += point - *below;
    const PlacedSkin own(plate.of, above, plate.rest, reach);
    const auto near = placed.near(point, plate.all, &own, std::int32_t(below - plate.rest.begin()));
    ASSERT_EQ(near.size(), 1) << distance;
    EXPECT_NEAR(near[0].normal[2], up, 1e-6) << distance;
  }
}

// Analytic: a free bar (nu = 0) of 1,573 nodes, which multigrid carries, between two plates: E A strain, and
// it does not glide away, though nothing keeps it from that.
TEST(BalanceAnalytic, AFreeBarBetweenPlatesIsPressed) {
  WorldScene scene = surfaces({20, 20, 22});
  scene.objects = {bar("bar", {10, 10, 12}, {5.2, 5.3, 2.1}, 1e4),
                   box_object("floor", ObjectKind::fixed, {16, 16, 1}, {2, 2, 1}),
                   box_object("plate", ObjectKind::rigid, {16, 16, 1}, {2, 2, 14.2})};
  World world(scene);
  for (int frame = 1; frame <= 4; ++frame) {
    const Drive drive = drive_of(2, {0, 0, -0.3});
    const FrameResult result = world.advance({&drive, 1});
    ASSERT_EQ(result.status, Status::done) << "frame " << frame << ": " << result.message;
    const double pressed = 0.3 * frame - 0.2 + 2 * skin, force = 1e4 * 100 * pressed / 12;
    EXPECT_NEAR(result.drives[0].force[2], -force, 1e-3 * force) << "frame " << frame;
    EXPECT_NEAR((force_on(result, 0, 1) + force_on(result, 0, 2)).norm(), 0, 1e-3 * force);
  }
  EXPECT_NEAR(world.position(0, 0)[0], 5.2, 0.05); // it has gone nowhere
  EXPECT_NEAR(world.position(0, 0)[1], 5.3, 0.05);
}

// Oracle: `coupled`, which is given the displacement of one node and finds the force.
TEST(FlexibilityOracle, ColumnsAreTheAnswersOfCoupled) {
  for (const auto& [dimension, solver, error] :
       {std::tuple(2, StiffnessSolver::factor, 1e-6), std::tuple(3, StiffnessSolver::factor, 1e-6),
        std::tuple(3, StiffnessSolver::multigrid, 1e-4)}) {
    WorldObject object =
        dimension == 2 ? elastic_object("body", {6, 5}, {}) : elastic_object("body", {4, 3, 3}, {});
    hold_face(object, 0, false);
    Scene& scene = object.scene;
    scene.relaxation.tolerance = 1e-9;
    std::vector<std::int64_t> fixed;
    for (const Prescribed& p : scene.prescribed)
      fixed.push_back(dimension * p.node + p.component);
    std::ranges::sort(fixed);
    Flexibility flexibility(scene, fixed, {}, false, 1, solver);
    const std::int64_t node = scene.specimen.grid.n_nodes() - 1;
    const Eigen::VectorXd column = flexibility.column(dimension * node + 1);
    Scene moved = scene; // by so much, by a force along y alone
    moved.prescribed.push_back({node, 1, column[dimension * node + 1], false});
    std::ranges::sort(moved.prescribed, {},
                      [](const Prescribed& p) { return std::pair(p.component, p.node); });
    const Answer answer = solve_coupled(moved, {});
    ASSERT_EQ(answer.status, Status::done) << answer.message;
    for (std::int64_t i = 0; i < scene.specimen.grid.n_nodes(); ++i)
      for (int b = 0; b < dimension; ++b)
        EXPECT_NEAR(answer.displacement(b, i), column[dimension * i + b],
                    error * column.cwiseAbs().maxCoeff());
    for (std::size_t i = 0; i < moved.prescribed.size(); ++i)
      if (!moved.prescribed[i].held) {
        EXPECT_NEAR(answer.reaction[i], 1, 10 * error); // the unit force
      }
  }
}

// Oracle: Eigen's factor of a matrix put together entry by entry, of an anisotropic body with a hole and
// cells that are partly tissue: columns, what held components that are moved do, forces at components, and
// the same with inertia.
TEST(FlexibilityOracle, MultigridAndTheSupernodalFactorAreEigensFactor) {
  WorldObject object = elastic_object("body", {5, 4, 6}, {});
  hold_face(object, 2, false);
  Scene& scene = object.scene;
  Specimen& body = scene.specimen;
  body.material_id.assign(std::size_t(body.grid.n_cells()), 0);
  body.material_id[std::size_t(body.grid.cell({2, 1, 3}))] =
      body.material_id[std::size_t(body.grid.cell({2, 2, 3}))] = no_material;
  body.tissue.assign(std::size_t(body.grid.n_cells()), 1);
  for (std::size_t cell = 0; cell < body.tissue.size(); cell += 3)
    body.tissue[cell] = 0.4F;
  std::vector<std::int64_t> fixed;
  for (const Prescribed& p : scene.prescribed)
    fixed.push_back(3 * p.node + p.component); // every node of the grid is the body's
  std::ranges::sort(fixed);
  const std::int64_t n = 3 * body.grid.n_nodes();
  for (const bool has_inertia : {false, true}) {
    const Eigen::VectorXd inertia =
        has_inertia ? Eigen::VectorXd(Eigen::VectorXd::LinSpaced(n, 1e3, 3e3)) : Eigen::VectorXd();
    Flexibility factor(scene, fixed, inertia, false, 1, StiffnessSolver::factor),
        multigrid(scene, fixed, inertia, false, 2, StiffnessSolver::multigrid),
        supernodal(scene, fixed, inertia, false, 1, StiffnessSolver::supernodal);
    const double error = has_inertia ? 1e-8 : 1e-4;
    std::vector<std::int64_t> all(static_cast<std::size_t>(n));
    std::iota(all.begin(), all.end(), 0);
    supernodal.find_columns(all);
    for (const std::int64_t component : all)
      ASSERT_LE((supernodal.column(component) - factor.column(component)).norm(),
                1e-10 * factor.column(component).norm())
          << "of component " << component;
    for (const std::int64_t component : {n - 1, n / 2, n / 3 + 1}) {
      const Eigen::VectorXd& expected = factor.column(component);
      EXPECT_LT((multigrid.column(component) - expected).norm(), error * expected.norm());
      EXPECT_NEAR(multigrid.force_at(component, expected), factor.force_at(component, expected), 1e-9);
      EXPECT_NEAR(multigrid.energy(expected), factor.energy(expected), 1e-9 * factor.energy(expected));
    }
    Eigen::VectorXd given = Eigen::VectorXd::Zero(n);
    for (const std::int64_t component : fixed)
      given[component] = 1e-3 * double(component % 7);
    const Eigen::VectorXd expected = factor.moved(given);
    EXPECT_LT((multigrid.moved(given) - expected).norm(), 1e-8 * expected.norm());
    EXPECT_LT((supernodal.moved(given) - expected).norm(), 1e-10 * expected.norm());
  }
}

// Oracle: the columns themselves, whatever sets of components were asked for before.
TEST(FlexibilityOracle, ComplianceIsKeptRight) {
  const WorldObject object = elastic_object("body", {6, 4}, {});
  Flexibility kept(object.scene, {0, 1, 12, 13}), anew(object.scene, {0, 1, 12, 13});
  const std::vector<std::vector<std::int64_t>> sets{
      {3, 8, 20}, {8, 20}, {2, 8, 15, 20, 31}, {40}, {2, 15, 40}};
  for (const std::vector<std::int64_t>& components : sets) {
    const Eigen::MatrixXd found = kept.compliance(components);
    ASSERT_EQ(found.rows(), std::ssize(components));
    for (Eigen::Index i = 0; i < found.rows(); ++i)
      for (Eigen::Index j = 0; j < found.cols(); ++j) {
        const std::int64_t p = components[std::size_t(i)], q = components[std::size_t(j)];
        EXPECT_EQ(found(i, j), 0.5 * (anew.column(p)[q] + anew.column(q)[p]));
      }
  }
}

// Independent: of a body that nothing holds, other components that take its rigid motions away. Analytic: it
// has no mean shift or turn, and its forces add up to nothing.
TEST(FlexibilityIndependent, WhatFloatsDoesNotKnowWhichComponentsWereChosen) {
  const WorldObject object = elastic_object("body", {6, 4}, {});
  const Grid& grid = object.scene.specimen.grid;
  const std::int64_t last = 2 * (grid.n_nodes() - 1);
  Flexibility one(object.scene, {0, 1, last}, {}, true), other(object.scene, {1, last, last + 1}, {}, true);
  for (const std::int64_t component : {std::int64_t{0}, std::int64_t{17}, last}) {
    const Eigen::VectorXd &a = one.column(component), &b = other.column(component);
    EXPECT_LT((a - b).norm(), 1e-9 * a.norm());
    Eigen::Vector2d shift = Eigen::Vector2d::Zero(), force = shift;
    double turn = 0;
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
      const Vec3 x = object.scene.specimen.position(grid.node_at(node));
      const Eigen::Vector2d u = a.segment<2>(2 * node);
      shift += u;
      turn += (x[0] * u[1] - x[1] * u[0]) / (grid.spacing()[0] * grid.cells()[0]);
      force += Eigen::Vector2d(one.force_at(2 * node, a), one.force_at(2 * node + 1, a));
    }
    EXPECT_LT(shift.norm() + std::abs(turn), 1e-9 * a.norm());
    EXPECT_LT(force.norm(), 1e-9);
  }
}

// Analytic: a bar (nu = 0) under a rigid plane: E A strain from the first touch on, whatever part of a cell
// the plane has gone, and wherever both lie in the world's cells.
TEST(BalanceAnalytic, AForceGrowsWithEveryPartOfACell) {
  for (const double shift : {0.0, 0.25, 0.5})
    for (const bool is_3d : {false, true}) {
      WorldScene scene = is_3d ? surfaces({10, 20, 10}) : surfaces({12, 24});
      const double z = is_3d ? 3 + shift : 0;
      scene.objects = {is_3d ? bar("bar", {2, 6, 2}, {4 + shift, 4, z}, 1e4)
                             : bar("bar", {4, 8}, {4 + shift, 4, 0}, 1e4),
                       is_3d ? box_object("plane", ObjectKind::rigid, {6, 2, 6}, {2 + shift, 10.5, 1 + shift})
                             : box_object("plane", ObjectKind::rigid, {8, 2}, {2 + shift, 12.5, 0})};
      hold_face(scene.objects[0], 1, false);
      World world(scene);
      const double height = is_3d ? 6 : 8, area = is_3d ? 4 : 4;
      for (int frame = 1; frame <= 8; ++frame) {
        const Drive drive = drive_of(1, {0, -0.2, 0});
        const FrameResult result = world.advance({&drive, 1});
        ASSERT_EQ(result.status, Status::done) << result.message;
        const double pressed = std::max(0.0, 0.2 * frame - 0.5 + skin);
        EXPECT_NEAR(result.drives[0].force[1], -1e4 * area * pressed / height, 1e-3 * 1e4 * area / height)
            << "shift " << shift << ", frame " << frame;
        EXPECT_EQ(world.n_penetrations(), 0);
      }
    }
}

// Analytic: two bars in a row are two springs in a row; what one feels the other feels.
TEST(BalanceAnalytic, TwoBarsPressedTogetherShareTheWay) {
  WorldScene scene = surfaces({40, 12});
  scene.objects = {bar("left", {6, 4}, {2, 4, 0}, 1e4), bar("right", {8, 4}, {8.3, 4, 0}, 3e4)};
  hold_face(scene.objects[1], 0, true);
  World world(scene);
  Drive drive = drive_of(0, {0.1, 0, 0});
  drive.nodes = test::face_nodes(scene.objects[0], 0, false);
  FrameResult result;
  for (int frame = 0; frame < 10; ++frame)
    result = world.advance({&drive, 1});
  ASSERT_EQ(result.status, Status::done) << result.message;
  const double pressed = 1 - 0.3 + skin, force = pressed / (6 / (1e4 * 4) + 8 / (3e4 * 4));
  EXPECT_NEAR(force_on(result, 1, 0)[0], force, 1e-6 * force);
  EXPECT_NEAR((force_on(result, 1, 0) + force_on(result, 0, 1)).norm(), 0, 1e-9 * force);
  EXPECT_NEAR(result.drives[0].force[0], force, 1e-6 * force);
}

/// Net force and moment on an object about a point.
std::pair<double, double> imbalance(const FrameResult& result, int object, const Eigen::Vector3d& about) {
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), moment = force;
  for (const WorldContact& contact : result.contacts)
    if (contact.object == object) {
      force += contact.force;
      moment += (*contact.at - about).cross(contact.force);
    }
  return {force.norm(), moment.norm()};
}

std::string disc(const std::string& name, double x, double y) {
  return fmt::format(R"([[object]]
name = "{}"
kind = "deformable"
shape = "ellipsoid"
cells = [14, 14]
material = {{ youngs_modulus = "10 kPa", poisson_ratio = 0.3 }}
position = ["{} mm", "{} mm"]
)",
                     name, x, y);
}

// Analytic: statics. Free discs between a plunger and the walls, and a mirror through their middle.
TEST(BalanceAnalytic, FreeDiscsAreInBalanceAndMirrorOneAnother) {
  World world(parse_world_scene(R"([world]
cells = [60, 44]
spacing = "1 mm"
contact = "surfaces"
[[object]]
name = "plunger"
kind = "rigid"
shape = "box"
cells = [3, 42]
position = ["1 mm", "1 mm"]
)" + disc("disc0", 6.5, 5.5) + disc("disc1", 6.5, 24.5) +
                                disc("disc2", 24.5, 15) + disc("disc3", 40.5, 5.5) +
                                disc("disc4", 40.5, 24.5)));
  const Drive drive = drive_of(0, {1e-3, 0, 0});
  int pressed = 0;
  for (int frame = 0; frame < 31; ++frame) {
    const FrameResult result = world.advance({&drive, 1});
    ASSERT_EQ(result.status, Status::done) << "frame " << frame << ": " << result.message;
    double largest = 1e-6; // what pushes a disc that nothing is in the way of is nothing [N]
    for (const WorldContact& contact : result.contacts)
      largest = std::max(largest, contact.force.norm());
    pressed += largest > 0.01;
    for (int object = 1; object <= 5; ++object) {
      const auto [force, moment] = imbalance(result, object, world.position(object, 7 * 15 + 7));
      EXPECT_LT(force, 1e-3 * largest) << "frame " << frame << ", object " << object;
      EXPECT_LT(moment, 1e-3 * largest * 7e-3) << "frame " << frame << ", object " << object;
      for (int other = 0; other <= 5; ++other)
        EXPECT_LT((force_on(result, object, other) + force_on(result, other, object)).norm(),
                  1e-9 * largest + 1e-15);
    }
    for (const auto& [one, other] : {std::pair(1, 2), std::pair(4, 5)}) {
      const Eigen::Vector3d a = world.position(one, 7 * 15 + 7), b = world.position(other, 7 * 15 + 7);
      EXPECT_NEAR(a[0], b[0], 1e-5 * 14e-3) << "frame " << frame;
      EXPECT_NEAR(a[1] - 22e-3, 22e-3 - b[1], 1e-5 * 14e-3) << "frame " << frame;
    }
    ASSERT_EQ(world.n_penetrations(), 0);
  }
  EXPECT_GE(pressed, 2); // the discs have room for 29 mm
}

// Analytic: a free plank that is pushed at one end, and leans on a fixed peg at the other, turns about the
// peg.
TEST(BalanceAnalytic, APlankPushedAtItsEndTurns) {
  WorldScene scene = surfaces({30, 30});
  scene.objects = {box_object("plank", ObjectKind::rigid, {12, 2}, {8, 12, 0}),
                   box_object("peg", ObjectKind::fixed, {1, 1}, {18.5, 14.2, 0}),
                   box_object("finger", ObjectKind::rigid, {1, 1}, {8.5, 10.5, 0})};
  World world(scene);
  const Drive drive = drive_of(2, {0, 0.5, 0});
  FrameResult result;
  for (int frame = 0; frame < 8; ++frame) {
    result = world.advance({&drive, 1});
    ASSERT_EQ(result.status, Status::done) << result.message;
    ASSERT_EQ(world.n_penetrations(), 0);
  }
  const Eigen::Matrix3d turned = world.pose(0).rotation;
  EXPECT_LT(std::asin(turned(1, 0)), -0.15); // 3.3 over the 10 between finger and peg, to the right
}

/// A C as in docs, its upper arm pushed down.
World closing_c() {
  return World(soft_rows(
      R"("####################","####################","####................","####................",
"####................","####................","####................","####................",
"####################","####################")",
      R"(hold = [{ where = "x-" }]
position = ["8.5 mm", "15.5 mm"]
)"));
}

// Contract: corners of stairs lie on edges of other stairs, and two faces at each edge ask for a direction of
// their own. The frames settle all the same; corners of one body that touch at rest are no
// contact of its own.
TEST(BalanceContract, AnEllipsoidInABellySettlesFrameByFrame) {
  World world(belly_and(R"([[object]]
name     = "probe"
kind     = "rigid"
shape    = "ellipsoid"
cells    = [5, 5, 8]
position = ["9.5 mm", "5 mm", "10.5 mm"]
)"));
  double before = 0;
  for (int frame = 0; frame < 5; ++frame) {
    const Drive drive = drive_of(1, {0, 0, -0.5e-3});
    const FrameResult result = world.advance({&drive, 1});
    ASSERT_EQ(result.status, Status::done) << "frame " << frame << ": " << result.message;
    for (const WorldContact& contact : result.contacts)
      EXPECT_NE(contact.object, contact.other);
    const Eigen::Vector3d down = force_on(result, 0, 1);
    EXPECT_LT(down[2], frame < 2 ? 1e-9 : before);
    EXPECT_LT((down + force_on(result, 1, 0)).norm(), 1e-9 * down.norm() + 1e-15);
    before = down[2];
  }
}

// Analytic: a hand's nodes come as far as the border, or a fixed wall, and no further: a step of a quarter of
// a cell is taken back. Nodes that go aside, or away, are not kept.
TEST(BalanceAnalytic, AHandForcesNoNodesThroughAWall) {
  for (const bool at_border : {true, false}) {
    WorldScene scene = surfaces({at_border ? 12 : 20, 12});
    scene.objects = {elastic_object("body", {3, 3}, {4, 4, 0})};
    if (!at_border)
      scene.objects.push_back(box_object("wall", ObjectKind::fixed, {2, 10}, {12, 1, 0}));
    World world(scene);
    Drive drive = drive_of(0, {9, 0, 0});
    drive.nodes = test::face_nodes(scene.objects[0], 0, true);
    const FrameResult result = world.advance({&drive, 1});
    EXPECT_EQ(result.status, Status::clamped) << result.message;
    const double x = world.position(0, drive.nodes[0])[0];
    EXPECT_LE(x, 12 + 0.01);
    EXPECT_GE(x, 12 - 0.25 - 0.01);
    EXPECT_EQ(world.n_penetrations(), 0);
    drive.motion.by = {-2, 0, 0};
    EXPECT_EQ(world.advance({&drive, 1}).status, Status::done);
    EXPECT_NEAR(world.position(0, drive.nodes[0])[0], x - 2, 1e-9);
  }
}

// Contract: no node of the upper arm is below the lower arm's upper side there, and what the arms press one
// another with is in balance: the lower arm goes down, too.
TEST(BalanceContract, AClosedCPushesItsOtherArm) {
  World world = closing_c();
  const Specimen& body = world.scene().objects[0].scene.specimen;
  Drive drive = drive_of(0, {0, -0.5e-3, 0});
  for (int x = 16; x <= 20; ++x)
    for (int y = 8; y <= 10; ++y)
      drive.nodes.push_back(body.grid.node({x, y, 0}));
  FrameResult result;
  for (int frame = 0; frame < 24; ++frame) {
    result = world.advance({&drive, 1});
    ASSERT_EQ(result.status, Status::done) << "frame " << frame << ": " << result.message;
  }
  double lowest = 0;
  for (int x = 6; x <= 20; ++x) {
    const Eigen::Vector3d above = world.position(0, body.grid.node({x, 8, 0}));
    for (int i = 4; i < 20; ++i) {
      const Eigen::Vector3d a = world.position(0, body.grid.node({i, 2, 0})),
                            b = world.position(0, body.grid.node({i + 1, 2, 0}));
      if (above[0] >= a[0] && above[0] <= b[0]) {
        EXPECT_GT(above[1], a[1] + (b[1] - a[1]) * (above[0] - a[0]) / (b[0] - a[0])) << "node " << x;
      }
    }
    lowest = std::min(lowest, world.position(0, body.grid.node({x, 0, 0}))[1] - 15.5e-3);
  }
  EXPECT_LT(lowest, -3e-3);
  EXPECT_FALSE(result.contacts.empty());
}

} // namespace
} // namespace maille::deform
