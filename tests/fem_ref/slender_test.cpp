/// Beams that are a hundred times as long as they are thick. What bends them is a millionth of what their
/// single cells resist with, so that the rounding of those forces is as large as what pulls: a residual
/// measured by the load alone says nothing there.

#include "bodies.hpp"

#include <gtest/gtest.h>

namespace maille {
namespace {

using fem_ref::LinearSolver;
using test::options_of;

constexpr double youngs_modulus = 1e6, traction = 0.01;

/// Of cells of 1 mm, held at one end, pulled across at the other.
Scene cantilever(const Index3& cells, double nu) {
  Scene scene = test::box_scene(3, cells);
  scene.materials.front().elasticity = ElasticConstants::isotropic(youngs_modulus, nu);
  test::hold_face(scene, 0, false);
  test::pull_face(scene, 0, true, {0, 0, -traction});
  return scene;
}

double mean_deflection_of_the_end(const Scene& scene, const Answer& answer) {
  const Grid& grid = scene.specimen.grid;
  double sum = 0, n = 0;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
    if (grid.node_at(node)[0] == grid.cells()[0]) {
      sum -= answer.displacement(2, node);
      ++n;
    }
  return sum / n;
}

/// Timoshenko's beam: bending, and shear with the coefficient 10 (1 + nu) / (12 + 11 nu) of a rectangle
/// (Cowper 1966).
double deflection_of_the_beam(const Index3& cells, double nu) {
  const double length = 1e-3 * cells[0], width = 1e-3 * cells[1], height = 1e-3 * cells[2];
  const double force = traction * width * height, area = width * height,
               inertia = width * std::pow(height, 3) / 12, shear_modulus = youngs_modulus / (2 * (1 + nu)),
               coefficient = 10 * (1 + nu) / (12 + 11 * nu);
  return force * std::pow(length, 3) / (3 * youngs_modulus * inertia) +
         force * length / (coefficient * shear_modulus * area);
}

// Truth: beam theory. The held end adds a length that is a hundredth of the beam's at most.
TEST(SlenderBeamAnalytic, QuadraticElementsBendAsABeamByEverySolver) {
  const Index3 cells{400, 2, 2};
  const Scene scene = cantilever(cells, 0.49);
  const double expected = deflection_of_the_beam(cells, 0.49);
  for (const LinearSolver solver : {LinearSolver::cholmod, LinearSolver::gmg}) { // AMG takes minutes
    SCOPED_TRACE(fem_ref::linear_solver_names[static_cast<std::size_t>(solver)]);
    const Answer answer = fem_ref::solve(scene, options_of(2, solver)).answer;
    ASSERT_EQ(answer.status, Status::done) << answer.message;
    EXPECT_NEAR(mean_deflection_of_the_end(scene, answer), expected, 0.01 * expected);
    EXPECT_LT(answer.residual, 1e-4);
  }
}

// Truth: one solver has nothing in common with another but the cells' matrices.
TEST(SlenderBeamOracle, SolversAgree) {
  const Scene scene = cantilever({400, 4, 4}, 0.49);
  const Answer truth = fem_ref::solve(scene, options_of(1, LinearSolver::cholmod)).answer;
  ASSERT_EQ(truth.status, Status::done) << truth.message;
  for (const LinearSolver solver : {LinearSolver::gmg, LinearSolver::cg_amg}) {
    SCOPED_TRACE(fem_ref::linear_solver_names[static_cast<std::size_t>(solver)]);
    const Answer answer = fem_ref::solve(scene, options_of(1, solver)).answer;
    ASSERT_EQ(answer.status, Status::done) << answer.message;
    EXPECT_LT(test::largest_difference(truth.displacement, answer.displacement),
              1e-4 * test::largest(truth.displacement));
  }
}

// Truth: of linear elements, that an answer does not depend on the size of the load.
TEST(SlenderBeamOracle, AThousandTimesTheLoadMovesAThousandTimesAsFar) {
  Scene scene = cantilever({400, 4, 4}, 0.49);
  const Answer one = fem_ref::solve(scene, options_of(1)).answer;
  for (FaceLoad& load : scene.tractions)
    load.traction[2] *= 1000;
  const Answer thousand = fem_ref::solve(scene, options_of(1)).answer;
  ASSERT_EQ(one.status, Status::done) << one.message;
  ASSERT_EQ(thousand.status, Status::done) << thousand.message;
  EXPECT_NEAR(test::largest(thousand.displacement) / test::largest(one.displacement), 1000, 0.01);
}

} // namespace
} // namespace maille
