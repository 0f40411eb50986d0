#include "elastic/componentwise/componentwise_preconditioner.hpp"
#include "elastic/ladder/ladder.hpp"
#include "elastic/limits/constrained_minimum.hpp"
#include "elastic/links/interval_field.hpp"
#include "feasible/bounds/clipping.hpp"
#include "feasible/feasible_set.hpp"
#include "maille/deform/solve.hpp"
#include "support/bodies/holed_bodies.hpp"
#include "support/bodies/scenes.hpp"
#include "support/dense_program.hpp"
#include "support/fields.hpp"
#include "support/kit.hpp"
#include "support/solved.hpp"

namespace maille::deform {
namespace {

using test::elastic_energy;
using test::even_limits;

/// A block poked in the middle of its top, deeply enough to use limits up.
Scene poked_block(int cells, double depth) {
  Scene scene = test::box_scene(3, {cells, cells, cells / 2});
  test::hold_face(scene, 2, false);
  const int low = (cells - cells / 4 + 1) / 2, high = (cells + cells / 4) / 2;
  test::move_patch(scene, {low, low, cells / 2}, {high, high, cells / 2}, {0, 0, -depth * cells / 2 * 1e-3});
  return test::with_limits(scene, even_limits(1.25, 0.75, 0.125));
}

/// The same, but no box of one material: a corner is stiffer, a cell is missing.
Scene poked_body(int cells, double depth) {
  Scene scene = poked_block(cells, depth);
  scene.materials.push_back(scene.materials[0]);
  scene.materials[1].elasticity = ElasticConstants::isotropic(20e3, 0.3);
  scene.specimen.material_id.assign(static_cast<std::size_t>(scene.specimen.grid.n_cells()), 0);
  scene.specimen.material_id.front() = 1;
  scene.specimen.material_id[static_cast<std::size_t>(cells + 1)] = no_material;
  return scene;
}

TEST(CoupledLimitsAnalytic, ARigidLinkInAChainGoesHalfTheWay) {
  Scene scene = test::box_scene(1, {5, 1, 1});
  scene.limits.from = LimitSource::material;
  scene.materials.push_back(scene.materials[0]);
  scene.materials[0].limits = even_limits(2, 0, 0);
  scene.materials[1].limits = even_limits(1, 1, 0);
  scene.specimen.material_id = {0, 0, 1, 0, 0};
  scene.prescribed = {{0, 0, 0, true}, {5, 0, 1e-3, false}};
  scene.relaxation.tolerance = 1e-7;
  const Answer answer = test::solved(scene, "coupled");
  EXPECT_NEAR(answer.displacement(0, 2), 0.5e-3, 1e-9);
  EXPECT_EQ(answer.displacement(0, 3), answer.displacement(0, 2));
  // Four springs C / h in a row, stretched by 1 mm in all; the rigid one only hands the pull on.
  const double stiffness = scene.cell_stiffness(0)(0, 0) / 1e-3 / 4;
  EXPECT_NEAR(answer.reaction.at(1), stiffness * 1e-3, 1e-5 * stiffness * 1e-3);
  EXPECT_NEAR(answer.reaction.at(0), -stiffness * 1e-3, 1e-5 * stiffness * 1e-3);
  EXPECT_NEAR(*answer.strain_energy, 0.5 * stiffness * 1e-6, 1e-5 * stiffness * 1e-6);
}

/// A small body in 2D or 3D, pulled and sheared at one end, some of its cells rigid, one missing.
Scene small_body(int dimension, unsigned seed) {
  Scene scene = test::box_scene(dimension, dimension == 2 ? Index3{6, 4, 1} : Index3{4, 2, 2});
  std::mt19937 random(seed);
  test::Dice dice{random};
  scene.materials.push_back(scene.materials[0]);
  scene.limits.from = LimitSource::material;
  scene.materials[0].limits = even_limits(1.1, 0.9, 0.06);
  scene.materials[1].limits = even_limits(1, 1, 0.06);
  scene.specimen.material_id.assign(static_cast<std::size_t>(scene.specimen.grid.n_cells()), 0);
  for (auto& material : scene.specimen.material_id)
    material = dice.below(5) == 0 ? 1 : 0;
  scene.specimen.material_id[5] = no_material;
  test::hold_face(scene, 0, false);
  test::move_face(scene, 0, true, {0.25e-3, 0.1e-3, -0.05e-3});
  return scene;
}

TEST(CoupledLimitsOracle, EqualsTheDenseQuadraticProgram) {
  int active = 0;
  for (const int dimension : {2, 3})
    for (unsigned seed = 1; seed <= 6; ++seed) {
      Scene scene = small_body(dimension, seed);
      scene.relaxation.tolerance = 1e-6;
      const LinkLimits limits(scene);
      const std::vector<Prescribed> clipped = clip(scene, limits).prescribed;
      const Answer answer = solve(scene, "coupled");
      ASSERT_TRUE(is_converged(answer.status)) << answer.message;
      EXPECT_LE(largest_violation(scene, limits, answer.displacement), 1e-12);
      Displacement expected;
      if (!test::dense_program(scene, clipped).solve(expected))
        continue;
      const double energy = elastic_energy(scene, expected);
      EXPECT_LE(test::relative_difference(answer.displacement, expected), 1e-4)
          << dimension << "D, seed " << seed;
      EXPECT_NEAR(*answer.strain_energy, energy, 1e-4 * energy) << dimension << "D, seed " << seed;
      active += answer.algorithm.find("multipliers") != std::string::npos ? 1 : 0;
    }
  EXPECT_GE(active, 8);
}

TEST(CoupledLimitsConsistent, EnergyIsThatOfALongRunAndBelowTheNearestFeasibleState) {
  for (Scene scene : {poked_block(12, 0.2), poked_body(12, 0.2), poked_block(16, 0.25)}) {
    const LinkLimits limits(scene);
    Scene elastic = scene;
    elastic.limits.from = LimitSource::taut; // binds nothing here
    Displacement nearest = solve(elastic, "coupled").displacement;
    FeasibleSet(scene, limits).bring_in(clip(scene, limits).prescribed, nearest);
    scene.relaxation.tolerance = 1e-2;
    const Answer answer = solve(scene, "coupled");
    scene.relaxation.tolerance = 1e-6;
    const Answer best = solve(scene, "coupled");
    ASSERT_TRUE(is_converged(answer.status) && is_converged(best.status)) << answer.message << best.message;
    EXPECT_LE(largest_violation(scene, limits, answer.displacement), 1e-12);
    EXPECT_LT(*answer.strain_energy, 0.98 * elastic_energy(scene, nearest));
    EXPECT_NEAR(*answer.strain_energy, *best.strain_energy, 0.01 * *best.strain_energy);
    EXPECT_LE(test::relative_difference(answer.displacement, best.displacement), 2e-2);
    EXPECT_LE(answer.residual, 1e-2 + 1e-2); // of the state before projection, and the projection
    EXPECT_NEAR(*answer.strain_energy, elastic_energy(scene, answer.displacement),
                1e-6 * *answer.strain_energy);
  }
}

/// The cube that the benchmark pokes.
Scene poked_cube(int cells, double depth) {
  Scene scene = test::box_scene(3, {cells, cells, cells});
  test::hold_face(scene, 2, false);
  const int low = 3 * cells / 8, high = 5 * cells / 8;
  test::move_patch(scene, {low, low, cells}, {high, high, cells}, {0, 0, -depth * cells * 1e-3});
  return test::with_limits(scene, even_limits(1.25, 0.75, 0.125));
}

// A state that is merely interpolated from a coarser body may be within a hundredth of the displacements, but
// what it presses with is far off.
TEST(CoupledLimitsConsistent, CoarserStartsEndNearALongRun) {
  Scene scene = poked_cube(32, 1.0 / 8);
  scene.relaxation.tolerance = 1e-2;
  const Answer answer = solve(scene, "coupled");
  scene.relaxation.tolerance = 1e-4;
  const Answer best = solve(scene, "coupled");
  ASSERT_TRUE(is_converged(answer.status) && is_converged(best.status)) << answer.message << best.message;
  EXPECT_NE(answer.algorithm.find("from coarser bodies"), std::string::npos) << answer.algorithm;
  EXPECT_LE(answer.iterations, 20); // 8 measured
  EXPECT_LE(test::relative_difference(answer.displacement, best.displacement), answer.residual);
  EXPECT_LE(answer.residual, 1e-2);
  EXPECT_NEAR(*answer.strain_energy, *best.strain_energy, 0.01 * *best.strain_energy);
  const double push = test::total_reaction(scene, best, 2, false);
  EXPECT_NEAR(test::total_reaction(scene, answer, 2, false), push, 0.1 * std::abs(push));
  EXPECT_NEAR(test::total_reaction(scene, answer, 2, true), -push, 0.1 * std::abs(push));
}

/// From coarser bodies and from the elastic answer.
void expect_any_start_serves(Scene scene) {
  scene.relaxation.tolerance = 1e-5;
  const LinkLimits limits(scene);
  const Clipping clipping = clip(scene, limits);
  ThreadTeam team(1);
  const Control control;
  const Clock clock;
  const CoupledTask task{scene, control, clipping.prescribed, team, clock, [] { return false; }, &limits};
  Answer answer, general;
  ASSERT_TRUE(solve_within_limits(task, answer));
  ASSERT_TRUE(solve_coupled_body(task, general));
  BodySystem body(task);
  const CellModuli moduli(scene);
  ConstrainedMinimum minimum(task, body, moduli, all_components(scene), loads_of(scene));
  ASSERT_TRUE(minimum.solve(general.displacement, scene.relaxation.tolerance, general));
  Displacement forces(scene.specimen.grid);
  body.apply(general.displacement, forces);
  general.strain_energy = 0.5 * test::product(general.displacement, forces);
  EXPECT_NE(answer.algorithm.find("multipliers"), std::string::npos) << answer.algorithm;
  EXPECT_LE(test::relative_difference(answer.displacement, general.displacement), 1e-4);
  EXPECT_NEAR(*answer.strain_energy, *general.strain_energy, 1e-4 * *general.strain_energy);
}

TEST(CoupledLimitsConsistent, TheStartChangesNoAnswer) {
  for (const Scene& scene : {poked_block(12, 0.2), poked_block(16, 0.25), poked_body(12, 0.2),
                             poked_body(test::cases(16, 12), 0.25)})
    expect_any_start_serves(scene);
}

TEST(CoupledLimitsAnalytic, ReactionsBalanceWhereLimitsAreActive) {
  for (Scene scene : {poked_block(8, 0.2), poked_body(8, 0.2)}) {
    scene.relaxation.tolerance = 1e-6;
    const Answer answer = test::solved(scene, "coupled");
    EXPECT_NE(answer.message.find("limits are active"), std::string::npos) << answer.message;
    const double push = std::abs(test::total_reaction(scene, answer, 2, false));
    for (int b = 0; b < 3; ++b)
      EXPECT_NEAR(test::total_reaction(scene, answer, b, true),
                  -test::total_reaction(scene, answer, b, false), 1e-5 * push);
  }
}

TEST(CoupledLimitsContract, StoppedOnCoarserBodiesItIsNearTheElasticAnswer) {
  const Scene scene = poked_block(16, 0.2);
  const LinkLimits limits(scene);
  Scene elastic = scene;
  elastic.limits.from = LimitSource::taut;
  const Answer free = solve(elastic, "coupled");
  Displacement nearest = free.displacement;
  FeasibleSet(scene, limits).bring_in(clip(scene, limits).prescribed, nearest);
  Control control;
  std::int64_t asked = 0;
  control.stop_requested = [&] { return ++asked > free.iterations + 2; };
  control.seconds_budget =
      1e9; // without a budget the elastic answer is skipped where the start clearly breaks limits
  const Answer answer = solve(scene, "coupled", control);
  EXPECT_EQ(answer.status, Status::interrupted);
  EXPECT_LE(test::relative_difference(answer.displacement, nearest), 1e-6);
}

TEST(CoupledLimitsContract, IsFeasibleWheneverItIsStopped) {
  for (const Scene& scene : {poked_block(8, 0.2), poked_body(8, 0.2)}) {
    const LinkLimits limits(scene);
    for (const int polls : {0, 2, 5, 12, 20}) {
      Control control;
      int asked = 0;
      control.stop_requested = [&] { return ++asked > polls; };
      const Answer answer = solve(scene, "coupled", control);
      EXPECT_EQ(answer.status, Status::interrupted) << polls;
      EXPECT_TRUE(answer.reaction.empty());
      EXPECT_GT(answer.residual, scene.relaxation.tolerance);
      EXPECT_LE(largest_violation(scene, limits, answer.displacement), 1e-12) << polls;
      EXPECT_NEAR(*answer.strain_energy, elastic_energy(scene, answer.displacement),
                  1e-6 * *answer.strain_energy);
      for (const Prescribed& p : scene.prescribed)
        EXPECT_EQ(answer.displacement(p.component, p.node), p.value);
    }
  }
}

TEST(CoupledLimitsContract, AComponentThatNothingPrescribesComesToItsOptimum) {
  Scene scene = test::box_scene(2, {6, 3, 1});
  test::prescribe_face(scene, 0, false, 0, 0, true);
  test::prescribe_face(scene, 0, true, 0, 0.6e-3, false);
  scene.prescribed.push_back({0, 1, 0, true});
  scene.limits.from = LimitSource::given;
  scene.limits.given = even_limits(1.2, 0.97, 0.1); // narrows by 3 % at most, where it would by 3 to 4
  scene.relaxation.tolerance = 1e-6;
  const Answer answer = test::solved(scene, "coupled");
  for (int y = 0; y <= 3; ++y)
    EXPECT_NEAR(answer.displacement(1, scene.specimen.grid.node({6, y, 0})), -0.03e-3 * y, 1e-8);
}

TEST(CoupledLimitsContract, LimitsOutOfReachAreFoundSoAndChangeNothing) {
  for (Scene scene : {poked_block(12, 0.1), poked_body(12, 0.1)}) {
    EXPECT_FALSE(permit_all_that_is_prescribed(LinkLimits(scene), scene)) << "they bind";
    scene.limits.given = even_limits(3, 0, 3);
    EXPECT_TRUE(permit_all_that_is_prescribed(LinkLimits(scene), scene));
    Scene without = scene;
    without.limits = {};
    for (const Method method : {Method::coupled, Method::relaxed}) {
      const Answer answer = solve(scene, method), expected = solve(without, method);
      EXPECT_EQ(answer.displacement, expected.displacement);
      EXPECT_EQ(answer.reaction, expected.reaction);
      EXPECT_EQ(answer.n_cut, 0);
      EXPECT_TRUE(answer.message.empty()) << answer.message;
    }
    scene.limits.given.stretch[2] = 1.01; // of one axis alone
    EXPECT_FALSE(permit_all_that_is_prescribed(LinkLimits(scene), scene));
  }
}

TEST(CoupledLimitsContract, AnyNumberOfThreadsGivesTheSameBits) {
  for (Scene scene :
       {poked_block(32, 0.2), poked_body(test::cases(40, 26), 0.2)}) { // enough nodes for threads to be used
    scene.relaxation.tolerance = 3e-2;
    test::expect_bits_of_any_threads(scene, "coupled", {2, 5});
  }
}

using test::total_reaction;

/// A clamped block pushed aside at its other end.
Scene pushed_block(int cells) {
  Scene scene = test::box_scene(3, {2 * cells, cells, cells});
  scene.materials[0].elasticity = ElasticConstants::transversely_isotropic(50e3, 10e3, 6e3, 0.3, 0.4);
  scene.specimen.fibre = {0.8, 0.6, 0};
  test::hold_face(scene, 0, false);
  test::move_face(scene, 0, true, {0.1e-3, 0.2e-3, 0});
  return scene;
}

TEST(CoupledAnalytic, ReactionsBalanceAndWorkTheEnergy) {
  Scene scene = pushed_block(4);
  scene.relaxation.tolerance = 1e-10;
  const Answer answer = test::solved(scene, "coupled");
  const double pull = total_reaction(scene, answer, 0, false);
  for (int b = 0; b < 3; ++b)
    EXPECT_NEAR(total_reaction(scene, answer, b, true), -total_reaction(scene, answer, b, false),
                1e-8 * pull); // equilibrium
  double half_work = 0;
  for (std::size_t i = 0; i < scene.prescribed.size(); ++i)
    half_work += 0.5 * scene.prescribed[i].value * answer.reaction[i];
  EXPECT_NEAR(*answer.strain_energy, half_work, 1e-9 * half_work); // Clapeyron
}

TEST(CoupledAnalytic, HoldsCarryTractionsAndWeight) {
  Scene scene = test::box_scene(3, {4, 3, 2});
  scene.relaxation.tolerance = 1e-10;
  scene.materials[0].density = 1000;
  scene.gravity = {0, 0, -10};
  test::hold_face(scene, 0, false);
  const double weight = 1000 * 10 * 24e-9; // rho g V
  const Answer answer = test::solved(scene, "coupled");
  EXPECT_NEAR(total_reaction(scene, answer, 2, true), weight, 1e-8 * weight);
}

TEST(CoupledConsistent, TheEstimatedErrorIsNearTheTrueOne) {
  Scene scene = pushed_block(8);
  scene.relaxation.tolerance = 1e-12;
  const Answer exact = solve(scene, "coupled"); // the oracle: the same, converged
  ASSERT_EQ(exact.status, Status::done) << exact.message;
  for (const double tolerance : {1e-2, 1e-3, 1e-5}) {
    scene.relaxation.tolerance = tolerance;
    const Answer answer = solve(scene, "coupled");
    EXPECT_LE(answer.residual, tolerance);
    // In the displacement, of which the energy norm is the stricter measure here.
    EXPECT_LE(test::relative_difference(answer.displacement, exact.displacement), tolerance);
  }
}

TEST(CoupledContract, ABodyThatCanStillMoveIsRefused) {
  Scene scene = test::box_scene(3, {2, 2, 2});
  test::prescribe_face(scene, 0, false, 0, 0, true);
  const Answer answer = solve(scene, "coupled");
  EXPECT_EQ(answer.status, Status::refused);
  EXPECT_NE(answer.message.find("hold or move more"), std::string::npos) << answer.message;
}

TEST(CoupledAnalytic, AComponentThatIsHeldInAPointOnlyIsSolvedTheSame) {
  // A bar on rollers: the answer is one strain everywhere, u_y = -nu strain y.
  Scene scene = test::box_scene(2, {6, 3, 1});
  scene.plane = PlaneAssumption::stress;
  scene.relaxation.tolerance = 1e-11;
  test::prescribe_face(scene, 0, false, 0, 0, true);
  test::prescribe_face(scene, 0, true, 0, 0.06e-3, false);
  scene.prescribed.push_back({0, 1, 0, true});
  const Answer answer = test::solved(scene, "coupled");
  for (int y = 0; y <= 3; ++y)
    EXPECT_NEAR(answer.displacement(1, scene.specimen.grid.node({6, y, 0})), -0.3 * 0.01 * y * 1e-3, 1e-12);
}

TEST(CoupledContract, BindingLimitsAreObeyedAndTheMessageSaysSo) {
  Scene scene = pushed_block(4);
  scene = test::with_limits(scene, even_limits(1.02, 0.98, 0.03));
  const Answer answer = solve(scene, "coupled");
  ASSERT_TRUE(is_converged(answer.status)) << answer.message;
  EXPECT_LE(largest_violation(scene, LinkLimits(scene), answer.displacement), 1e-9);
  EXPECT_NE(answer.message.find("limits are active"), std::string::npos) << answer.message;
}

TEST(CoupledContract, ATimeBudgetEndsInAUsableState) {
  Scene scene = pushed_block(12);
  scene.relaxation.tolerance = 1e-12;
  Control control;
  control.seconds_budget = 0;
  const Answer answer = solve(scene, "coupled", control);
  EXPECT_EQ(answer.status, Status::budget_reached);
  for (const Prescribed& p : scene.prescribed)
    EXPECT_EQ(answer.displacement(p.component, p.node), p.value);
}

} // namespace
} // namespace maille::deform
