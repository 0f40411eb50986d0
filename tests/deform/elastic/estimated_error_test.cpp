/// Errors that are known, estimated.

#include "elastic/ladder/ladder.hpp"
#include "elastic/resample/coarser_scene.hpp"
#include "maille/deform/estimated_error.hpp"
#include "maille/deform/solve.hpp"
#include "maille/scene/answer.hpp"
#include "maille/scene/cell_fields.hpp"
#include "maille/scene/frame.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/refined.hpp"
#include "support/bodies/lattice_scenes.hpp"
#include "support/bodies/scenes.hpp"
#include "support/fields.hpp"
#include "support/kit.hpp"

namespace maille::deform {
namespace {

/// Held at its foot, its top pushed aside and down.
Scene pushed(int dimension, Index3 cells) {
  Scene scene = test::box_scene(dimension, cells);
  test::hold_face(scene, dimension - 1, false);
  test::move_face(scene, dimension - 1, true, {0.3e-3, dimension == 2 ? -0.2e-3 : 0.1e-3, -0.4e-3});
  return scene;
}

/// Two kinds of matter, and a corner that is not there.
Scene pushed_body(Index3 cells) {
  Scene scene = pushed(3, cells);
  scene.materials.push_back(scene.materials[0]);
  scene.materials[1].elasticity = ElasticConstants::isotropic(50e3, 0.4);
  auto& kinds = scene.specimen.material_id;
  kinds.assign(std::size_t(scene.specimen.grid.n_cells()), 0);
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    const Index3 at = scene.specimen.grid.cell_at(std::int64_t(i));
    if (at[0] > cells[0] / 2 && at[2] > 2 && at[2] < 6)
      kinds[i] = at[1] > cells[1] / 2 ? no_material : 1;
  }
  return scene;
}

/// A bump of 0.02 mm, below small_model_error; zero at everything that is prescribed, at all nodes of the
/// body.
Displacement bump(const Scene& scene) {
  const Grid& grid = scene.specimen.grid;
  Displacement u(grid);
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    const Index3 at = grid.node_at(node);
    if (!scene.specimen.is_node(at))
      continue;
    double value = 0.02e-3;
    for (int a = 0; a < scene.dimension(); ++a)
      value *= std::sin(std::numbers::pi * (at[std::size_t(a)] + 0.2) / grid.nodes()[std::size_t(a)]);
    for (int c = 0; c < scene.dimension(); ++c)
      u(c, node) = c == 1 ? -0.5 * value : value;
  }
  for (const Prescribed& p : scene.prescribed)
    u(p.component, p.node) = 0;
  return u;
}

Displacement sum(Displacement a, const Displacement& b, double factor = 1) {
  for (std::size_t i = 0; i < a.values().size(); ++i)
    a.values()[i] += factor * b.values()[i];
  return a;
}

/// What the estimate says more of a converged answer with a bump than of it alone is the bump.
void expect_bump_is_found(Scene scene) {
  scene.relaxation.tolerance = 1e-10;
  const Answer converged = solve(scene, "coupled");
  ASSERT_EQ(converged.status, Status::done);
  scene.relaxation.tolerance = 1e-4;
  const Displacement wrong = bump(scene);
  const ErrorEstimation alone = estimate_error(scene, converged.displacement),
                        bumped = estimate_error(scene, sum(converged.displacement, wrong));
  ASSERT_TRUE(alone.estimate) << alone.reason;
  ASSERT_TRUE(bumped.estimate) << bumped.reason;
  ASSERT_EQ(alone.estimate->lattice, bumped.estimate->lattice); // the same of the lattice in both
  const Displacement found = sum(bumped.estimate->error, alone.estimate->error, -1);
  // A step of less than 5 % ends the correction; what is left of it then is of that size.
  EXPECT_LE(test::norm(sum(found, wrong, -1)), 0.05 * test::norm(wrong));
}

TEST(EstimatedErrorConsistent, ABumpOnAConvergedAnswerIsFound) {
  expect_bump_is_found(pushed(3, {8, 8, 8}));    // a box that can be halved
  expect_bump_is_found(pushed(3, {7, 9, 8}));    // and one that cannot
  expect_bump_is_found(pushed_body({8, 9, 10})); // a body of two kinds of matter
  expect_bump_is_found(pushed(2, {16, 12, 1}));
}

/// A cube of 8 mm, pushed aside and down.
Scene cube(int n) {
  Scene scene = test::box_scene(3, {n, n, n}, Vec3{8e-3 / n, 8e-3 / n, 8e-3 / n});
  test::hold_face(scene, 2, false);
  test::move_face(scene, 2, true, {0.3e-3, 0, -0.4e-3});
  scene.relaxation.tolerance = 1e-6;
  return scene;
}

TEST(EstimatedErrorConsistent, ThePartOfTheLatticeIsThatOfAnswersOnFinerLattices) {
  // The truth: coupled on eight times as many cells an axis, of which 1 / 8 of the error is left.
  const Scene scene = cube(8), fine = cube(64);
  const Displacement answer = solve(scene, "coupled").displacement,
                     best = solve(fine, "coupled").displacement;
  Displacement truth(scene.specimen.grid);
  for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node) {
    const Index3 at = scene.specimen.grid.node_at(node);
    for (int c = 0; c < 3; ++c)
      truth(c, node) = best(c, fine.specimen.grid.node({8 * at[0], 8 * at[1], 8 * at[2]}));
  }
  const ErrorEstimation found = estimate_error(scene, answer);
  ASSERT_TRUE(found.estimate) << found.reason;
  EXPECT_EQ(found.estimate->lattice, OtherLattice::finer);
  const double true_error = compare(scene, answer, truth).relative_l2;
  EXPECT_GT(true_error, 1e-3) << "something to be found";
  EXPECT_GT(found.estimate->norms.relative_l2, true_error);
  EXPECT_LT(found.estimate->norms.relative_l2, true_error * 2);
}

/// Held at one end, the other one moved along and across.
Scene bent(Index3 cells, double poisson_ratio) {
  Scene scene = test::box_scene(3, cells);
  scene.materials[0].elasticity = ElasticConstants::isotropic(10e3, poisson_ratio);
  test::hold_face(scene, 0, false);
  test::move_face(scene, 0, true, {0.2e-3, 0, 0.4e-3});
  return scene;
}

// The truth: coupled on a quarter of the spacing, which has a sixteenth to a quarter of the error. From twice
// the spacing the estimate was six to thirty-five times too large where matter is nearly incompressible, and
// a third of the error on plates one cell thick. The last is stretched by 20 % and bent by 22 degrees.
TEST(EstimatedErrorConsistent, HardBodiesAreEstimatedToo) {
  Scene large = bent({8, 4, 4}, 0.45);
  large.strain = Strain::finite;
  for (Prescribed& p : large.prescribed)
    p.value *= 8;
  for (const Scene& scene :
       {bent({12, 8, 8}, 0.499), bent({8, 6, 6}, 0.4999), bent({12, 10, 1}, 0.45), large}) {
    if (test::is_sanitized && scene.specimen.grid.cells()[2] > 1)
      continue;
    Scene half = refined(scene), quarter = refined(half);
    quarter.relaxation.tolerance = 1e-6;
    const Displacement truth =
        at_coarse_nodes(scene, half, at_coarse_nodes(half, quarter, solve(quarter, "coupled").displacement));
    const Displacement answer = solve(scene, "coupled").displacement;
    const double true_error = compare(scene, answer, truth).relative_l2;
    const ErrorEstimation found = estimate_error(scene, answer);
    ASSERT_TRUE(found.estimate) << found.reason;
    EXPECT_GT(found.estimate->norms.relative_l2, true_error);
    EXPECT_LT(found.estimate->norms.relative_l2, true_error * 2);
  }
}

TEST(EstimatedErrorAnalytic, AUniformStretchHasNoErrorAndABumpOnItIsAllOfTheError) {
  Scene scene = test::box_scene(3, {8, 10, 8});
  const Displacement exact = test::affine_displacement<Displacement>(
      scene, {{{0.02, 0.01, 0}, {0, -0.01, 0.005}, {0.004, 0, -0.006}}});
  const Grid& grid = scene.specimen.grid;
  for (int c = 0; c < 3; ++c)
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
      const Index3 at = grid.node_at(node);
      bool is_outer = false;
      for (std::size_t a = 0; a < 3; ++a)
        is_outer = is_outer || at[a] == 0 || at[a] == grid.nodes()[a] - 1;
      if (is_outer)
        scene.prescribed.push_back({node, c, exact(c, node), false});
    }
  const ErrorEstimation none = estimate_error(scene, exact);
  ASSERT_TRUE(none.estimate) << none.reason;
  EXPECT_LE(none.estimate->norms.relative_l2, 1e-6); // float32 inside the cycles
  const Displacement wrong = bump(scene);
  const ErrorEstimation found = estimate_error(scene, sum(exact, wrong));
  ASSERT_TRUE(found.estimate) << found.reason;
  EXPECT_LE(test::norm(sum(found.estimate->error, wrong, -1)), 0.05 * test::norm(wrong));
  EXPECT_NEAR(found.estimate->norms.relative_l2, compare(scene, sum(exact, wrong), exact).relative_l2,
              0.05 * found.estimate->norms.relative_l2);
}

/// A bar that is stretched and turned as a whole.
Scene turned_by(double angle) {
  Scene scene = test::box_scene(3, {8, 6, 6});
  for (const bool upper : {false, true})
    test::move_face(scene, 0, upper, {});
  const double c = std::cos(angle), s = std::sin(angle);
  for (Prescribed& p : scene.prescribed) {
    const Vec3 x = scene.specimen.position(scene.specimen.grid.node_at(p.node));
    const Vec3 turned{c * 1.05 * x[0] - s * x[1], s * 1.05 * x[0] + c * x[1], x[2]};
    const auto b = std::size_t(p.component);
    p.value = turned[b] - x[b];
    p.condition = x[0] > 0.5e-3; // two ends, whose forces cancel in sum
  }
  return scene;
}

TEST(EstimatedErrorAnalytic, TheEstimateTurnsWithTheBody) {
  const Scene straight = turned_by(0), turned = turned_by(0.5);
  ASSERT_TRUE(object_frame(turned).is_turned);
  const ErrorEstimation a = estimate_error(straight, solve(straight, "limits").displacement),
                        b = estimate_error(turned, solve(turned, "limits").displacement);
  ASSERT_TRUE(a.estimate && b.estimate) << a.reason << b.reason;
  EXPECT_NEAR(a.estimate->norms.rms, b.estimate->norms.rms, 1e-3 * a.estimate->norms.rms);
  for (std::int64_t node = 0; node < straight.specimen.grid.n_nodes(); ++node) {
    const double c = std::cos(0.5), s = std::sin(0.5), x = a.estimate->error(0, node),
                 y = a.estimate->error(1, node);
    EXPECT_NEAR(b.estimate->error(0, node), c * x - s * y, 0.01 * a.estimate->norms.rms);
    EXPECT_NEAR(b.estimate->error(1, node), s * x + c * y, 0.01 * a.estimate->norms.rms);
  }
}

TEST(EstimatedErrorContract, SaysWhichOtherLatticeItLookedAt) {
  const auto lattice = [](const Scene& scene, const char* method) {
    const ErrorEstimation found = estimate_error(scene, solve(scene, method).displacement);
    EXPECT_TRUE(found.estimate) << found.reason;
    return found.estimate ? found.estimate->lattice : OtherLattice::none;
  };
  EXPECT_EQ(lattice(pushed(3, {8, 8, 8}), "coupled"), OtherLattice::finer);
  EXPECT_EQ(lattice(pushed(3, {8, 8, 8}), "limits"), OtherLattice::coarser) << "some 20 % off";
  EXPECT_EQ(lattice(pushed(3, {7, 8, 8}), "coupled"), OtherLattice::finer);
  EXPECT_EQ(lattice(pushed(3, {7, 8, 8}), "limits"), OtherLattice::none) << "some 20 % off";
  Scene odd = pushed(3, {8, 8, 8}); // where one node more is held the coarser body is not held alike
  odd.prescribed.push_back({odd.specimen.grid.node({3, 3, 3}), 2, 0, true});
  EXPECT_EQ(lattice(odd, "limits"), OtherLattice::none);
}

TEST(EstimatedErrorContract, SameBitsForAnyNumberOfThreads) {
  const Scene scene = pushed(3, {24, 24, 24});
  const Displacement limits = solve(scene, "limits").displacement;
  Control two;
  two.threads = 2;
  const ErrorEstimation a = estimate_error(scene, limits), b = estimate_error(scene, limits, two);
  ASSERT_TRUE(a.estimate && b.estimate);
  EXPECT_EQ(a.estimate->error, b.estimate->error);
}

TEST(EstimatedErrorContract, SaysWhyThereIsNone) {
  Scene scene = pushed(3, {7, 8, 8});
  const Displacement answer = solve(scene, "coupled").displacement;
  Control control;
  control.bytes_budget = 1000;
  EXPECT_NE(estimate_error(scene, answer, control).reason.find("needs about"), std::string::npos);
  control.bytes_budget = bytes_needed(scene, "coupled") * 2; // not enough for half the spacing
  EXPECT_NE(estimate_error(scene, answer, control).reason.find("no memory"), std::string::npos);
  control = {};
  control.stop_requested = [] { return true; };
  EXPECT_NE(estimate_error(scene, answer, control).reason.find("stopped"), std::string::npos);
  scene.prescribed.resize(1);
  const ErrorEstimation loose = estimate_error(scene, answer);
  EXPECT_FALSE(loose.estimate);
  EXPECT_FALSE(loose.reason.empty());
}

/// Errors of force, energy, strain and stress that are known, estimated.

/// A bar of 12 cells, pulled: any lattice answers it without an error.
Scene bar() {
  Scene scene = test::box_scene(1, {12, 1, 1});
  test::hold_face(scene, 0, false);
  test::move_face(scene, 0, true, {0.5e-3, 0, 0});
  scene.relaxation.tolerance = 1e-8;
  return scene;
}

MechanicsErrors estimated(const Scene& scene, const Answer& answer) {
  const ErrorEstimation found = estimate_error(scene, answer);
  EXPECT_TRUE(found.estimate) << found.reason;
  return found.estimate ? found.estimate->mechanics : MechanicsErrors{};
}

// Analytic: the bar's force is E times its strain; forces and an energy that are made too large are too large
// by that.
TEST(EstimatedMechanicsAnalytic, ForcesAndEnergiesThatAreTooLargeAreTooLargeByThat) {
  const Scene scene = bar();
  Answer answer = solve(scene, "coupled");
  const MechanicsErrors none = estimated(scene, answer);
  EXPECT_LE(none.force.value(), 1e-6);
  EXPECT_LE(none.strain_energy.value(), 1e-6);
  EXPECT_LE(none.strain.value(), 1e-6);
  EXPECT_LE(none.stress.value(), 1e-6);
  for (double& force : answer.reaction)
    force *= 1.3;
  *answer.strain_energy *= 0.6;
  const MechanicsErrors found = estimated(scene, answer);
  EXPECT_NEAR(found.force.value(), 0.3, 1e-6);
  EXPECT_NEAR(found.strain_energy.value(), 0.4, 1e-6);
  EXPECT_LE(found.stress.value(), 1e-6) << "is told by the displacement";
}

// Analytic: strains that are wrong to and fro by a tenth, cell by cell, are wrong by a tenth.
TEST(EstimatedMechanicsAnalytic, StrainsThatAreWrongToAndFroAreWrongByThat) {
  const Scene scene = bar();
  Answer answer = solve(scene, "coupled");
  const double strain = 0.5e-3 / 12e-3;
  for (std::int64_t node = 1; node < 12; node += 2)
    answer.displacement(0, node) += 0.1 * strain * 1e-3;
  const MechanicsErrors found = estimated(scene, answer);
  EXPECT_NEAR(found.strain.value(), 0.1, 0.005) << "a correction is settled at 5 % of it";
  EXPECT_NEAR(found.stress.value(), 0.1, 0.005);
  EXPECT_LE(found.force.value(), 1e-6) << "is told by the reactions";
}

// Oracle: coupled on a quarter of the spacing, strain as means over the cells that a cell is cut into.
TEST(EstimatedMechanicsConsistent, AreNearTheErrorsAgainstFinerLattices) {
  const Scene scene = cube(8), half = refined(scene), quarter = refined(half);
  Answer truth = solve(quarter, "coupled");
  truth.cell_strain = cell_fields(quarter, truth.displacement).strain;
  bring_to_coarse(half, quarter, truth);
  bring_to_coarse(scene, half, truth);
  for (const char* method : {"coupled", "relaxed"}) {
    const Answer answer = solve(scene, method);
    const MechanicsErrors errors = compare_mechanics(scene, answer, truth), found = estimated(scene, answer);
    for (const auto part : {&MechanicsErrors::force, &MechanicsErrors::strain_energy,
                            &MechanicsErrors::strain, &MechanicsErrors::stress}) {
      ASSERT_TRUE((errors.*part).has_value() && (found.*part).has_value()) << method;
      EXPECT_GT(*(errors.*part), 1e-3) << "something to be found";
      EXPECT_LT(*(found.*part), 2 * *(errors.*part)) << method;
      EXPECT_GT(*(found.*part), *(errors.*part) / 2) << method;
    }
  }
}

// Analytic: a body that is turned as a whole has the same forces, in its own frame.
TEST(EstimatedMechanicsAnalytic, TurnWithTheBody) {
  const Scene straight = turned_by(0), turned = turned_by(0.5);
  ASSERT_TRUE(object_frame(turned).is_turned);
  const MechanicsErrors a = estimated(straight, solve(straight, "relaxed")),
                        b = estimated(turned, solve(turned, "relaxed"));
  EXPECT_GT(a.force.value(), 1e-2);
  EXPECT_NEAR(a.force.value(), b.force.value(), 1e-3 * *a.force);
  EXPECT_NEAR(a.stress.value(), b.stress.value(), 1e-3 * *a.stress);
}

TEST(EstimatedMechanicsContract, MethodsWithoutForcesHaveAnErrorOfStrainAlone) {
  const Scene scene = cube(8);
  const MechanicsErrors found = estimated(scene, solve(scene, "limits"));
  EXPECT_FALSE(found.force || found.strain_energy || found.stress);
  EXPECT_GT(found.strain.value(), 0.1);
}

TEST(EstimatedMechanicsContract, ADisplacementAloneHasNone) {
  const Scene scene = cube(8);
  const ErrorEstimation found = estimate_error(scene, solve(scene, "coupled").displacement);
  ASSERT_TRUE(found.estimate);
  EXPECT_FALSE(found.estimate->mechanics.force || found.estimate->mechanics.strain);
}

/// `coupled` on nested lattices: what extrapolation gains, and where it stays away.

/// A block held at its foot, whose top is pressed down and aside in its middle half along x, and y where
/// `in_the_middle`.
Scene pressed_block(Index3 cells, bool in_the_middle, const ElasticConstants& elasticity) {
  Scene scene = test::box_scene(3, cells);
  scene.materials[0].elasticity = elasticity;
  scene.specimen.fibre = {0.8, 0, 0.6};
  test::hold_face(scene, 2, false);
  Index3 low{0, 0, cells[2]}, high = cells;
  for (std::size_t a = 0; a < 2 && in_the_middle; ++a) {
    low[a] = (cells[a] + 3) / 4;
    high[a] = 3 * cells[a] / 4;
  }
  test::move_patch(scene, low, high, {0, 0.02e-3, -0.1e-3});
  return scene;
}

Scene bent_bar(const ElasticConstants& elasticity) {
  Scene scene = test::box_scene(3, {32, 16, 16});
  scene.materials[0].elasticity = elasticity;
  scene.specimen.fibre = {0.8, 0, 0.6};
  test::hold_face(scene, 0, false);
  test::move_face(scene, 0, true, {0, 0, 1e-3});
  return scene;
}

ElasticConstants isotropic(double poisson) {
  return ElasticConstants::isotropic(10e3, poisson);
}

ElasticConstants fibrous() {
  return ElasticConstants::transversely_isotropic(100e3, 10e3, 4e3, 0.3, 0.3);
}

Answer solved(Scene scene, Extrapolation extrapolation) {
  scene.relaxation.tolerance = 1e-4;
  scene.relaxation.extrapolation = extrapolation;
  Answer answer = solve(scene, "coupled");
  EXPECT_EQ(answer.status, Status::done) << answer.message;
  return answer;
}

/// Relative L2 errors without and with extrapolation, against the same question on cells a quarter as large.
struct Errors {
  double plain, extrapolated, share;
};
Errors errors_of(const Scene& scene) {
  const Scene finer = refined(scene), finest = refined(finer);
  const Displacement fine = at_coarse_nodes(
      scene, finer, at_coarse_nodes(finer, finest, solved(finest, Extrapolation::none).displacement));
  const Answer extrapolated = solved(scene, Extrapolation::nested);
  return {compare(scene, solved(scene, Extrapolation::none).displacement, fine).relative_l2,
          compare(scene, extrapolated.displacement, fine).relative_l2, extrapolated.extrapolated.value()};
}

TEST(ExtrapolationConsistent, PokesGainAndNothingLoses) {
  struct Case {
    const char* name;
    Scene scene;
    double most; // of the error that is left
  };
  // The oracle is the lattice of a quarter of the spacing, itself off by a quarter of the plain error of a
  // poke.
  std::vector<Case> cases;
  for (const double poisson : {0.0, 0.3, 0.45, 0.49})
    cases.push_back({"poke", pressed_block({16, 16, 16}, true, isotropic(poisson)), 0.7});
  cases.push_back({"poke with fibres", pressed_block({16, 16, 16}, true, fibrous()), 0.7});
  for (const double poisson : {0.3, 0.45, 0.49}) {
    cases.push_back({"pull", pressed_block({16, 16, 16}, false, isotropic(poisson)), 1});
    cases.push_back({"bend", bent_bar(isotropic(poisson)), 1});
  }
  cases.push_back({"pull with fibres", pressed_block({16, 16, 16}, false, fibrous()), 1});
  cases.push_back({"bend with fibres", bent_bar(fibrous()), 1});
  if (test::is_sanitized)
    cases.resize(1);
  for (const Case& test_case : cases) {
    const Errors errors = errors_of(test_case.scene);
    SCOPED_TRACE(testing::Message() << test_case.name << ": " << errors.plain << " -> " << errors.extrapolated
                                    << ", share " << errors.share);
    EXPECT_LE(errors.extrapolated, test_case.most * errors.plain);
    if (test_case.most < 1) {
      EXPECT_GT(errors.share, 0.4);
    }
  }
}

/// An L of two materials in cells of 4 mm, cut twice in half along every axis.
Scene cut_twice() {
  Scene scene = test::box_scene(3, {8, 4, 8}, {4e-3, 4e-3, 4e-3});
  scene.materials.push_back(scene.materials[0]);
  scene.materials[1].elasticity = isotropic(0.45);
  for (int z = 0; z < 8; ++z)
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 8; ++x)
        scene.specimen.material_id.push_back(x >= 4 && z >= 4 ? no_material : std::uint8_t(y / 2));
  test::hold_face(scene, 2, false);
  test::move_patch(scene, {1, 1, 8}, {3, 3, 8}, {1e-3, 0, 0});
  return refined(refined(scene));
}

TEST(ExtrapolationConsistent, ABodyOfTwoMaterialsGains) {
  const Scene scene = cut_twice();
  const Answer plain = solved(scene, Extrapolation::none),
               extrapolated = solved(scene, Extrapolation::nested);
  const Scene finer = refined(scene);
  const Displacement fine = at_coarse_nodes(scene, finer, solved(finer, Extrapolation::none).displacement);
  // The finer lattice is off by half of what the plain answer is, so no more than that half can be gained
  // against it.
  EXPECT_LE(compare(scene, extrapolated.displacement, fine).relative_l2,
            compare(scene, plain.displacement, fine).relative_l2);
  EXPECT_GT(extrapolated.extrapolated.value(), 0.4);
  EXPECT_NE(extrapolated.algorithm.find("extrapolated from three lattices"), std::string::npos);
}

TEST(ExtrapolationContract, WhatIsPrescribedStaysToTheBit) {
  const Scene scene = pressed_block({16, 16, 16}, true, isotropic(0.3));
  const Answer answer = solved(scene, Extrapolation::nested);
  for (const Prescribed& p : scene.prescribed)
    ASSERT_EQ(answer.displacement(p.component, p.node), p.value);
}

TEST(ExtrapolationContract, TheSceneAsksForIt) {
  const std::string box = test::box_text("4") + test::hold_text();
  const auto asked = [&](const std::string& more) {
    return parse_scene(box + more, "scene.toml").relaxation.extrapolation;
  };
  EXPECT_EQ(asked(""), Extrapolation::none);
  EXPECT_EQ(asked("[relaxation]\nextrapolation = \"none\"\n"), Extrapolation::none);
  EXPECT_EQ(asked("[relaxation]\nextrapolation = \"nested\"\n"), Extrapolation::nested);
  EXPECT_THROW(asked("[relaxation]\nextrapolation = \"richardson\"\n"), InputError);
}

TEST(ExtrapolationContract, ItsMemoryIsForeseen) {
  for (Scene scene : {pressed_block({32, 32, 32}, true, isotropic(0.3)), cut_twice()}) {
    scene.relaxation.extrapolation = Extrapolation::nested;
    const Answer answer = solve(scene, "coupled");
    ASSERT_GT(answer.extrapolated.value(), 0) << answer.message;
    EXPECT_LE(answer.bytes, bytes_needed(scene, "coupled"));
  }
}

TEST(ExtrapolationContract, IsOffByDefault) {
  const Scene scene = pressed_block({16, 16, 16}, true, isotropic(0.3));
  EXPECT_FALSE(solved(scene, Extrapolation::none).extrapolated.has_value());
}

/// The answer is that of the lattice, and the message says why.
void expect_left_alone(const Scene& scene, const std::string& why) {
  SCOPED_TRACE(why);
  const Answer answer = solved(scene, Extrapolation::nested), plain = solved(scene, Extrapolation::none);
  EXPECT_EQ(answer.extrapolated.value(), 0);
  EXPECT_NE(answer.message.find("not extrapolated"), std::string::npos) << answer.message;
  EXPECT_NE(answer.message.find(why), std::string::npos) << answer.message;
  EXPECT_LE(compare(scene, answer.displacement, plain.displacement).relative_l2, 1e-4); // the tolerance
}

TEST(ExtrapolationContract, WhatCoarserLatticesCannotSayIsLeftAlone) {
  expect_left_alone(pressed_block({18, 16, 16}, false, isotropic(0.3)), "halved twice");
  Scene shifted = pressed_block({16, 16, 16}, true, isotropic(0.3));
  std::erase_if(shifted.prescribed, [&](const Prescribed& p) { // an edge of the patch between coarse nodes
    return !p.held && shifted.specimen.grid.node_at(p.node)[0] == 4;
  });
  expect_left_alone(shifted, "prescribed");
  Scene poked = test::box_scene(3, {16, 16, 16}); // a single node has no limit on ever finer lattices
  test::hold_face(poked, 2, false);
  test::move(poked, {8, 8, 16}, {0, 0, -1e-3});
  expect_left_alone(poked, "differ by");
  Scene carved = cut_twice();
  carved.specimen.material_id[0] = no_material;
  expect_left_alone(carved, "matter");
  Scene uneven = test::box_scene(3, {16, 16, 16});
  test::hold_face(uneven, 2, false);
  uneven.tractions.push_back({uneven.specimen.grid.cell({8, 8, 15}), 2, true, {0, 0, -1e3}});
  expect_left_alone(uneven, "traction");
}

TEST(ExtrapolationAnalytic, AnExactAnswerStaysExact) {
  Scene scene = test::box_scene(
      3, {16, 16, 16}); // without Poisson effect a pull is one strain everywhere, on any lattice
  scene.materials[0].elasticity = isotropic(0);
  test::hold_face(scene, 2, false);
  test::move_face(scene, 2, true, {0, 0, 1e-3});
  const Displacement exact =
      test::affine_displacement<Displacement>(scene, {{{0, 0, 0}, {0, 0, 0}, {0, 0, 1.0 / 16}}});
  EXPECT_LE(compare(scene, solved(scene, Extrapolation::nested).displacement, exact).relative_l2, 1e-4);
}

TEST(ExtrapolationContract, LimitsAreObeyed) {
  Scene scene = pressed_block({16, 16, 16}, true, isotropic(0.3));
  scene.limits.from = LimitSource::given;
  scene.limits.given = test::even_limits(1.2, 0.9, 0.2); // wide
  const Answer wide = solved(scene, Extrapolation::nested);
  EXPECT_GT(wide.extrapolated.value(), 0) << wide.message;
  EXPECT_LE(largest_violation(scene, LinkLimits(scene), wide.displacement), 1e-9);
  scene.limits.given = test::even_limits(1.2, 0.994, 0.2);
  scene.relaxation.extrapolation = Extrapolation::nested;
  const Answer active = solve(scene, "coupled");
  EXPECT_LE(largest_violation(scene, LinkLimits(scene), active.displacement), 1e-9);
  EXPECT_NE(active.message.find("limits are active"), std::string::npos) << active.message;
  EXPECT_NE(active.message.find("not extrapolated, because limits are active"), std::string::npos)
      << active.message;
}

TEST(NestedLatticesConsistent, AStartFromCoarserBoxesChangesNoAnswer) {
  Scene scene = pressed_block({32, 28, 30}, true, isotropic(0.45));
  scene.relaxation.tolerance = 1e-9;
  const Answer nested = solve(scene, "coupled");
  ThreadTeam team(1);
  const Control control;
  const Clock clock;
  Answer alone; // the oracle: from nothing
  ASSERT_TRUE(solve_on_ladder({scene, control, scene.prescribed, team, clock, [] { return false; }}, alone));
  EXPECT_LE(compare(scene, nested.displacement, alone.displacement).relative_l2, 2e-9);
  EXPECT_NEAR(*nested.strain_energy, *alone.strain_energy, 1e-10 * *alone.strain_energy);
}

TEST(CoarserSceneAnalytic, RefiningBringsBackWhatWasCoarsened) {
  const Scene scene = cut_twice();
  const std::optional<Scene> coarse = coarser_scene(scene, scene.prescribed);
  ASSERT_TRUE(coarse);
  EXPECT_EQ(what_coarsening_loses(*coarse, scene, scene.prescribed), "");
}

TEST(InterpolationAnalytic, LinearFieldsAreKept) {
  ThreadTeam team(2);
  for (const bool is_carved : {false, true}) {
    Scene coarse = test::box_scene(3, {3, 4, 5});
    if (is_carved) {
      coarse.specimen.material_id.assign(60, 0);
      coarse.specimen.material_id[59] = no_material;
    }
    const Scene fine = refined(coarse);
    const std::array<Vec3, 3> gradient{{{1, 2, 3}, {-1, 0.5, 2}, {0, 4, -2}}};
    const Displacement exact = test::affine_displacement<Displacement>(fine, gradient);
    Displacement u(fine.specimen.grid);
    interpolate(coarse.specimen, test::affine_displacement<Displacement>(coarse, gradient).values(),
                fine.specimen, u.values(), team);
    for (std::int64_t node = 0; node < fine.specimen.grid.n_nodes(); ++node) {
      if (!fine.specimen.is_node(fine.specimen.grid.node_at(node)))
        continue;
      for (int b = 0; b < 3; ++b)
        EXPECT_NEAR(u(b, node), exact(b, node), is_carved ? 1.5e-3 : 1e-15) << node; // one-sided at the notch
    }
  }
}

} // namespace
} // namespace maille::deform
