#include "maille/deform/solve.hpp"
#include "support/bodies/scenes.hpp"
#include "support/fields.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace maille::deform {
namespace {

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
  const Answer answer = solve(scene, "coupled");
  ASSERT_EQ(answer.status, Status::done) << answer.message;
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
  const Answer answer = solve(scene, "coupled");
  ASSERT_EQ(answer.status, Status::done) << answer.message;
  EXPECT_NEAR(total_reaction(scene, answer, 2, true), weight, 1e-8 * weight);
}

TEST(CoupledOracle, TheEstimatedErrorIsNearTheTrueOne) {
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

TEST(CoupledContract, AnyNumberOfThreadsGivesTheSameBits) {
  const Scene scene = pushed_block(24); // enough nodes for threads to be used
  const Answer one = solve(scene, "coupled");
  Control control;
  for (const int threads : {2, 3, 7}) {
    control.threads = threads;
    EXPECT_EQ(solve(scene, "coupled", control).displacement, one.displacement) << threads;
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
  const Answer answer = solve(scene, "coupled");
  ASSERT_EQ(answer.status, Status::done) << answer.message;
  for (int y = 0; y <= 3; ++y)
    EXPECT_NEAR(answer.displacement(1, scene.specimen.grid.node({6, y, 0})), -0.3 * 0.01 * y * 1e-3, 1e-12);
}

TEST(CoupledContract, BindingLimitsAreObeyedAndTheMessageSaysSo) {
  Scene scene = pushed_block(4);
  scene.limits.from = LimitSource::given;
  scene.limits.given.stretch.fill(1.02);
  scene.limits.given.compress.fill(0.98);
  for (auto& row : scene.limits.given.shear)
    row.fill(0.03);
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
