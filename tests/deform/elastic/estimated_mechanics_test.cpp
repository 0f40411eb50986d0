/// Errors of force, energy, strain and stress that are known, estimated.

#include "maille/deform/estimated_error.hpp"
#include "maille/deform/solve.hpp"
#include "maille/scene/cell_fields.hpp"
#include "maille/scene/frame.hpp"
#include "maille/scene/refined.hpp"
#include "support/bodies/scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace maille::deform {
namespace {

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

/// A cube of 8 mm, pushed aside and down.
Scene cube(int n) {
  Scene scene = test::box_scene(3, {n, n, n}, Vec3{8e-3 / n, 8e-3 / n, 8e-3 / n});
  test::hold_face(scene, 2, false);
  test::move_face(scene, 2, true, {0.3e-3, 0, -0.4e-3});
  scene.relaxation.tolerance = 1e-6;
  return scene;
}

// Oracle: coupled on a quarter of the spacing, strain as means over the cells that a cell is cut into.
TEST(EstimatedMechanicsOracle, AreNearTheErrorsAgainstFinerLattices) {
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
  const auto turned_by = [](double angle) {
    Scene scene = test::box_scene(3, {8, 6, 6});
    for (const bool upper : {false, true})
      test::move_face(scene, 0, upper, {});
    const double c = std::cos(angle), s = std::sin(angle);
    for (Prescribed& p : scene.prescribed) {
      const Vec3 x = scene.specimen.position(scene.specimen.grid.node_at(p.node));
      const Vec3 turned{c * 1.05 * x[0] - s * x[1], s * 1.05 * x[0] + c * x[1], x[2]};
      const auto b = static_cast<std::size_t>(p.component);
      p.value = turned[b] - x[b];
      p.condition = x[0] > 0.5e-3; // two ends, whose forces cancel in sum
    }
    return scene;
  };
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

} // namespace
} // namespace maille::deform
