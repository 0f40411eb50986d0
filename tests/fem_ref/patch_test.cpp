// Constant strain must come out to round-off, whatever the matter and the shape (Irons 1972).

#include "fem_ref/bodies.hpp"
#include "maille/scene/cell_fields.hpp"
#include "support/kit.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>

namespace maille {
namespace {

using test::options_of;

struct Matter {
  const char* name;
  ElasticConstants constants;
  bool slanted;
};

std::vector<Matter> matters() {
  return {{"isotropic", ElasticConstants::isotropic(10e3, 0.3), false},
          {"orthotropic", test::orthotropic(), false},
          {"turned transversely isotropic", test::fibrous(), true}};
}

Scene body(int dimension, const Matter& matter, bool carved) {
  const Index3 cells = dimension == 1 ? Index3{9, 1, 1} : dimension == 2 ? Index3{7, 6, 1} : Index3{6, 5, 5};
  Scene scene = test::box_scene(dimension, cells, {2e-3, 1e-3, 1.5e-3});
  scene.specimen.origin = {0.01, -0.02, 0.03};
  scene.materials[0] = test::material_of(matter.constants);
  if (matter.slanted)
    scene.specimen.fibre = test::slanted_fibre(dimension);
  if (carved)
    test::carve(scene, 5, 0.15);
  return scene;
}

Vec3 affine(const Vec3& x) {
  return {1e-4 + 0.02 * x[0] - 0.03 * x[1] + 0.01 * x[2], 2e-4 + 0.04 * x[0] + 0.01 * x[1] - 0.02 * x[2],
          -0.01 * x[0] + 0.03 * x[1] - 0.015 * x[2]};
}

TEST(PatchTestAnalytic, LinearDisplacementOnTheBoundaryFillsTheBody) {
  for (int dimension = 1; dimension <= 3; ++dimension)
    for (const Matter& matter : matters())
      for (const bool carved : {false, true})
        for (const int degree : {1, 2}) {
          SCOPED_TRACE(
              fmt::format("{}D {} {} Q{}", dimension, matter.name, carved ? "carved" : "box", degree));
          const Scene scene = body(dimension, matter, carved);
          fem_ref::Options options = options_of(degree);
          options.boundary_displacement = affine;
          options.exact = affine;
          const fem_ref::Result result = test::solved(scene, options);
          // Truth: a linear displacement has constant stress and solves the equations without load.
          const double size = test::largest(result.answer.displacement);
          EXPECT_LT(test::largest_error(scene, result.answer.displacement, affine), 1e-10 * size);
          EXPECT_LT(*result.l2_error, 1e-10 * size);
        }
}

TEST(PatchTestAnalytic, FibresGivenPerCellActAsTheOneTheyEqual) {
  for (int dimension = 2; dimension <= 3; ++dimension) {
    Scene scene = body(dimension, matters()[2], false);
    const Vec3 f = scene.specimen.fibre;
    scene.specimen.fibres.assign(std::size_t(scene.specimen.grid.n_cells()),
                                 {float(f[0]), float(f[1]), float(f[2])});
    fem_ref::Options options = options_of(1);
    options.boundary_displacement = affine;
    const fem_ref::Result result = fem_ref::solve(scene, options);
    EXPECT_LT(test::largest_error(scene, result.answer.displacement, affine),
              1e-10 * test::largest(result.answer.displacement));
  }
}

/// Prescribes the component of one node to be zero.
void pin(Scene& scene, const Index3& node, int component) {
  scene.prescribed.push_back({scene.specimen.grid.node(node), component, 0, true});
}

// Uniform tractions on all six faces, just six components held: the stress is that of the tractions
// everywhere, the strain is S sigma, and the displacement is the linear one that the supports allow.
TEST(PatchTestAnalytic, UniformTractionsGiveTheStrainOfTheCompliance) {
  Eigen::Matrix<double, 6, 1> stress; // 11 22 33 23 13 12
  stress << 100, -50, 30, 20, -40, 60;
  const int full[3][3] = {{0, 5, 4}, {5, 1, 3}, {4, 3, 2}};
  for (const Matter& matter : matters())
    for (const int degree : {1, 2}) {
      SCOPED_TRACE(fmt::format("{} Q{}", matter.name, degree));
      Scene scene = test::box_scene(3, {4, 3, 3}, {2e-3, 1e-3, 1.5e-3});
      scene.materials[0] = test::material_of(matter.constants);
      if (matter.slanted)
        scene.specimen.fibre = test::slanted_fibre(3);
      for (int axis = 0; axis < 3; ++axis)
        for (const bool upper : {false, true}) {
          Vec3 traction{};
          for (int c = 0; c < 3; ++c)
            traction[std::size_t(c)] = (upper ? 1 : -1) * stress[full[c][axis]];
          test::pull_face(scene, axis, upper, traction);
        }
      for (int c = 0; c < 3; ++c)
        pin(scene, {0, 0, 0}, c);
      pin(scene, {4, 0, 0}, 1); // no turn about z
      pin(scene, {4, 0, 0}, 2); // nor about y
      pin(scene, {0, 3, 0}, 2); // nor about x
      const fem_ref::Result result = test::solved(scene, options_of(degree));

      const Eigen::Matrix<double, 6, 1> e = scene.object_stiffness(0).inverse() * stress;
      const auto exact = [&](const Vec3& x) -> Vec3 {
        return {e[0] * x[0] + e[5] * x[1] + e[4] * x[2], e[1] * x[1] + e[3] * x[2], e[2] * x[2]};
      };
      const double size = test::largest(result.answer.displacement);
      EXPECT_LT(test::largest_error(scene, result.answer.displacement, exact), 1e-10 * size);
    }
}

// A displacement that is known everywhere: the error falls with the order of the element. More in
// studies/lab/verify/orders.cpp.

// Truth: the cantilever of Timoshenko and Goodier 1951, article 21 (plane stress, end load P on depth D),
// which solves the equations without body force; origin in the middle of the fixed end.
TEST(ManufacturedAnalytic, PlaneStressCantileverConverges) {
  const double E = 10e3, nu = 0.3, P = 2.0, L = 4.0, D = 1.0, I = D * D * D / 12;
  const auto exact = [=](const Vec3& x) -> Vec3 {
    const double y = x[1];
    return {
        P * y / (6 * E * I) * ((6 * L - 3 * x[0]) * x[0] + (2 + nu) * (y * y - D * D / 4)),
        -P / (6 * E * I) *
            (3 * nu * y * y * (L - x[0]) + (4 + 5 * nu) * D * D * x[0] / 4 + (3 * L - x[0]) * x[0] * x[0]),
        0};
  };
  for (const int degree : {1, 2}) {
    std::vector<double> errors;
    for (const int cells : {4, 8}) {
      const double h = D / cells;
      Scene scene = test::box_scene(2, {4 * cells, cells, 1}, {h, h, h});
      scene.specimen.origin = {0, -D / 2, 0};
      scene.plane = PlaneAssumption::stress;
      fem_ref::Options options = options_of(degree);
      options.boundary_displacement = exact;
      options.exact = exact;
      errors.push_back(fem_ref::solve(scene, options).l2_error.value());
    }
    EXPECT_NEAR(std::log2(errors[0] / errors[1]), degree + 1, 0.15);
  }
}

// Truth: quadratic elements hold a quadratic displacement exactly; its strain is linear, so a cell's mean is
// that at its middle, and the stress that of the mean.
TEST(CellStrainAnalytic, QuadraticElementsGiveTheirOwnMeans) {
  for (const int dimension : {2, 3}) {
    const Scene scene = test::box_scene(dimension, {3, 2, dimension == 3 ? 2 : 1}, {1e-3, 1.5e-3, 2e-3});
    const auto n = std::size_t(dimension);
    const double bend[3][3] = {{7, -4, 3}, {2, 6, -5}, {-3, 1, 8}};
    const auto exact = [&](const Vec3& x) -> Vec3 {
      Vec3 u{};
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j)
          u[i] += bend[i][j] * x[j] * x[(j + i) % n];
      return u;
    };
    const auto strain = [&](const Vec3& x) {
      Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j) {
          const std::size_t k = (j + i) % n;
          gradient(int(i), int(j)) += bend[i][j] * x[k];
          gradient(int(i), int(k)) += bend[i][j] * x[j];
        }
      return Eigen::Matrix3d((gradient + gradient.transpose()) / 2);
    };
    const auto stress = [&](const Vec3& x) {
      const Eigen::Matrix3d e = strain(x);
      Vector6 voigt;
      voigt << e(0, 0), e(1, 1), e(2, 2), 2 * e(1, 2), 2 * e(0, 2), 2 * e(0, 1);
      const Vector6 s = scene.object_stiffness(0) * voigt;
      Eigen::Matrix3d tensor;
      tensor << s(0), s(5), s(4), s(5), s(1), s(3), s(4), s(3), s(2);
      return tensor;
    };
    Vec3 force{};
    for (std::size_t j = 0; j < n; ++j) {
      Vec3 one{};
      one[j] = 1;
      const Eigen::Matrix3d slope = stress(one) - stress({});
      for (std::size_t i = 0; i < n; ++i)
        force[i] -= slope(int(i), int(j));
    }
    fem_ref::Options options = options_of(2);
    options.boundary_displacement = exact;
    options.body_force = [&](const Vec3&) { return force; };
    const Answer answer = test::solved(scene, options).answer;
    const CellFields own = cell_fields(scene, answer);
    double largest = 0;
    const Grid& grid = scene.specimen.grid;
    for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
      Vec3 middle = scene.specimen.position(grid.cell_at(cell));
      for (std::size_t a = 0; a < n; ++a)
        middle[a] += grid.spacing()[a] / 2;
      const Eigen::Matrix3d e = strain(middle), s = stress(middle);
      const auto c = std::size_t(cell);
      constexpr int row[6] = {0, 1, 2, 0, 1, 0}, column[6] = {0, 1, 2, 1, 2, 2};
      for (std::size_t k = 0; k < 6; ++k) {
        EXPECT_NEAR(own.strain[c][k], e(row[k], column[k]), 1e-9 * 0.05);
        EXPECT_NEAR(own.stress[c][k], s(row[k], column[k]), 1e-9 * 0.05 * 1e6);
        largest = std::max(largest, std::abs(e(row[k], column[k])));
      }
    }
    EXPECT_GT(largest, 0.01);
  }
}

// Which bodies are refused because they can still move as a whole.

Answer answer_of(const Scene& scene) {
  return fem_ref::solve(scene, options_of(1)).answer;
}

void expect_refused(const Scene& scene, const std::string& why) {
  const Answer answer = answer_of(scene);
  EXPECT_EQ(answer.status, Status::refused);
  EXPECT_EQ(answer.message, why);
  EXPECT_TRUE(answer.displacement.empty());
}

TEST(RigidMotionContract, NothingPrescribedIsRefused) {
  for (int dimension = 1; dimension <= 3; ++dimension)
    expect_refused(test::box_scene(dimension, {3, 3, 3}),
                   "nothing is held or moved, so the body can move anywhere");
}

TEST(RigidMotionContract, MessageNamesTheMotion) {
  Scene roller = test::box_scene(2, {3, 3, 1});
  test::prescribe_face(roller, 0, false, 0, 0, true);
  expect_refused(roller, "the body can still move along y: hold or move more of it");

  Scene hinge = test::box_scene(2, {3, 3, 1});
  hinge.prescribed = {{5, 0, 0, true}, {5, 1, 0, true}};
  expect_refused(hinge, "the body can still turn about z: hold or move more of it");

  Scene axle = test::box_scene(3, {3, 3, 3});
  for (int c = 0; c < 3; ++c)
    for (int x = 0; x <= 3; ++x)
      axle.prescribed.push_back({axle.specimen.grid.node({x, 0, 0}), c, 0, true});
  expect_refused(axle, "the body can still turn about x: hold or move more of it");

  Scene table = test::box_scene(3, {3, 3, 3});
  test::prescribe_face(table, 2, false, 2, 0, true);
  expect_refused(table, "the body can still move along x, y and turn about z: hold or move more of it");
}

TEST(RigidMotionContract, MessageNamesThePiece) {
  Scene scene = test::box_scene(3, {5, 1, 1});
  scene.specimen.material_id = {0, 0, no_material, 0, 0};
  test::hold_face(scene, 0, false);
  expect_refused(scene,
                 "piece 2 of 2 (2 cells about (0.003, 0, 0) m) can still move along x, y, z and turn about "
                 "x, y, z: hold or move more of it");
}

/// A flat scene of single cells: '#' is matter; the first line is the upper one.
Scene drawing(const std::vector<std::string>& lines) {
  const auto width = static_cast<int>(lines[0].size()), height = static_cast<int>(lines.size());
  Scene scene = test::box_scene(2, {width, height, 1});
  for (auto line = lines.rbegin(); line != lines.rend(); ++line)
    for (const char c : *line)
      scene.specimen.material_id.push_back(c == '#' ? std::uint8_t{0} : no_material);
  return scene;
}

void hold_node(Scene& scene, const Index3& node) {
  for (int c = 0; c < 2; ++c)
    scene.prescribed.push_back({scene.specimen.grid.node(node), c, 0, true});
}

TEST(RigidMotionContract, PiecesMayHoldEachOtherThroughCorners) {
  Scene hinged = drawing({".#", //
                          "#."});
  hold_node(hinged, {0, 0});
  hold_node(hinged, {0, 1});
  expect_refused(hinged,
                 "piece 2 of 2 (1 cells about (0.001, 0.001, 0) m) can still turn about z: hold or move more "
                 "of it");
  hold_node(hinged, {2, 2});
  EXPECT_EQ(answer_of(hinged).status, Status::done);

  // Three pieces joined in a triangle: stiff together, though each can turn about every one of its corners.
  Scene triangle = drawing({".#.", //
                            "#.#", //
                            ".##"});
  hold_node(triangle, {0, 1});
  hold_node(triangle, {0, 2});
  EXPECT_EQ(answer_of(triangle).status, Status::done);
  Scene opened = drawing({".#.", //
                          "#.#", //
                          "..#"});
  hold_node(opened, {0, 1});
  hold_node(opened, {0, 2});
  EXPECT_EQ(answer_of(opened).status, Status::refused);
}

/// Motions of a plane body of Q1 cells that cost no energy and keep the prescribed components: by singular
/// values of the strains at 2 x 2 points of every cell, and of the conditions. The obvious version.
int motions_without_strain(const Scene& scene) {
  const Grid& grid = scene.specimen.grid;
  const auto n = static_cast<Eigen::Index>(grid.n_nodes());
  std::vector<Eigen::RowVectorXd> rows;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell)
    for (int point = 0; scene.specimen.is_matter(cell) && point < 4; ++point) {
      const double x = point & 1 ? 0.8 : 0.2, y = point & 2 ? 0.8 : 0.2;
      Eigen::RowVectorXd xx = Eigen::RowVectorXd::Zero(2 * n), yy = xx, xy = xx;
      for (int corner = 0; corner < 4; ++corner) {
        const Eigen::Index node = grid.corner(grid.cell_at(cell), corner);
        const double dx = (corner & 1 ? 1 : -1) * (corner & 2 ? y : 1 - y);
        const double dy = (corner & 2 ? 1 : -1) * (corner & 1 ? x : 1 - x);
        xx[2 * node] = dx;
        yy[2 * node + 1] = dy;
        xy[2 * node] = dy;
        xy[2 * node + 1] = dx;
      }
      rows.insert(rows.end(), {xx, yy, xy});
    }
  const auto fix = [&](Eigen::Index unknown) {
    rows.push_back(Eigen::RowVectorXd::Zero(2 * n));
    rows.back()[unknown] = 1;
  };
  for (const Prescribed& p : scene.prescribed)
    fix(2 * p.node + p.component);
  for (Eigen::Index node = 0; node < n; ++node)
    if (!scene.specimen.is_node(grid.node_at(node)))
      for (int c = 0; c < 2; ++c)
        fix(2 * node + c);
  Eigen::MatrixXd matrix(static_cast<Eigen::Index>(rows.size()), 2 * n);
  for (std::size_t k = 0; k < rows.size(); ++k)
    matrix.row(static_cast<Eigen::Index>(k)) = rows[k];
  const Eigen::VectorXd values = Eigen::JacobiSVD<Eigen::MatrixXd>(matrix).singularValues();
  return static_cast<int>((values.array() < 1e-9 * values[0]).count());
}

TEST(RigidMotionOracle, RefusesExactlyTheBodiesThatCanMove) {
  std::mt19937 random(20240611);
  int refused = 0, solved = 0;
  for (int k = 0; k < 300; ++k) {
    Scene scene = test::box_scene(2, {4, 4, 1});
    test::carve(scene, static_cast<unsigned>(k), 0.45);
    for (int condition = 0; condition < 6; ++condition) {
      const auto node = static_cast<std::int64_t>(random() % 25);
      if (scene.specimen.is_node(scene.specimen.grid.node_at(node)))
        scene.prescribed.push_back({node, static_cast<int>(random() % 2), 0, true});
    }
    if (scene.prescribed.empty() || scene.specimen.n_matter_cells() == 0)
      continue;
    const Answer answer = answer_of(scene);
    const int motions = motions_without_strain(scene);
    EXPECT_EQ(answer.status, motions > 0 ? Status::refused : Status::done)
        << fmt::format("body {}: {} motions, {}", k, motions, answer.message);
    ++(motions > 0 ? refused : solved);
  }
  EXPECT_GT(refused, 20); // both kinds occurred
  EXPECT_GT(solved, 20);
}

} // namespace
} // namespace maille
