// The linear solvers, and what a caller may ask of a running one.
#include "fem_ref/bodies.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace maille {
namespace {

using fem_ref::LinearSolver;
using test::options_of;

/// A carved block of two kinds of matter with slanted fibres, held, moved, pulled and weighed down.
Scene rich_scene(int dimension) {
  const Index3 cells = dimension == 1   ? Index3{40, 1, 1}
                       : dimension == 2 ? Index3{20, 12, 1}
                                        : Index3{10, 6, 5};
  Scene scene = test::box_scene(dimension, cells, {1e-3, 1.2e-3, 0.8e-3});
  scene.materials = {test::material_of(test::fibrous()),
                     test::material_of(ElasticConstants::isotropic(5e3, 0.4))};
  scene.specimen.fibre = test::slanted_fibre(dimension);
  scene.specimen.material_id.assign(static_cast<std::size_t>(scene.specimen.grid.n_cells()), 0);
  for (std::int64_t cell = 0; cell < scene.specimen.grid.n_cells(); ++cell) {
    const Index3 at = scene.specimen.grid.cell_at(cell);
    if (at[0] >= 5)
      scene.specimen.material_id[static_cast<std::size_t>(cell)] = 1;
    if (dimension > 1 && at[0] >= 3 && at[0] < 6 && at[1] >= 2 && at[1] < 4) // a hole
      scene.specimen.material_id[static_cast<std::size_t>(cell)] = no_material;
  }
  test::hold_face(scene, 0, false);
  test::move_face(scene, 0, true, {1e-3, -5e-4, 2e-4});
  if (dimension > 1)
    test::pull_face(scene, 1, true, {20, 30, -10});
  scene.gravity = {0, -9.81, 0};
  return scene;
}

// Truth: the same equations solved three ways. CG at 1e-12, the condition number is below 1e4.
TEST(SolversOracle, Agree) {
  for (int dimension = 1; dimension <= 3; ++dimension)
    for (const int degree : {1, 2}) {
      SCOPED_TRACE(fmt::format("{}D Q{}", dimension, degree));
      const Scene scene = rich_scene(dimension);
      const Answer cholmod = fem_ref::solve(scene, options_of(degree, LinearSolver::cholmod)).answer;
      const Answer cg = fem_ref::solve(scene, options_of(degree, LinearSolver::cg_amg)).answer;
      for (const Answer* answer : {&cholmod, &cg})
        ASSERT_EQ(answer->status, Status::done) << answer->message;
      const double size = test::largest(cholmod.displacement);
      EXPECT_LT(test::largest_difference(cholmod.displacement, cg.displacement), 1e-8 * size);
    }
}

TEST(SolversContract, WhoAsksForLessIsAnsweredToo) {
  fem_ref::Options options = options_of(1, LinearSolver::cg_amg);
  const Answer exact = fem_ref::solve(rich_scene(3), options).answer;
  options.tolerance = 1e-3;
  const Answer loose = fem_ref::solve(rich_scene(3), options).answer;
  ASSERT_EQ(loose.status, Status::done) << loose.message;
  EXPECT_GT(loose.residual, 1e-6) << "else nothing was tried";
  EXPECT_LE(loose.residual, 2e-3);
  EXPECT_LT(loose.iterations, exact.iterations);
}

TEST(SolversContract, AnswerIsFilledIn) {
  Scene scene = test::box_scene(3, {4, 2, 2});
  test::hold_face(scene, 0, false);
  test::pull_face(scene, 0, true, {10, 0, 0});
  const std::pair<LinearSolver, std::string> cases[] = {
      {LinearSolver::cholmod, "Q1, CHOLMOD "}, // supernodal or not is CHOLMOD's choice
      {LinearSolver::cg_amg, "Q1, CG with smoothed-aggregation AMG, "}};
  for (const auto& [solver, algorithm] : cases) {
    const fem_ref::Result result = fem_ref::solve(scene, options_of(1, solver));
    EXPECT_EQ(result.answer.method, "fem_q1");
    // Four of five layers of nine nodes are free: 108 unknowns of 135.
    const std::string found = result.answer.algorithm;
    EXPECT_EQ(found.substr(0, algorithm.size()), algorithm);
    EXPECT_EQ(found.substr(found.rfind(',')), ", 108 unknowns");
    EXPECT_EQ(result.degrees_of_freedom, 135);
    EXPECT_EQ(result.answer.iterations > 0, solver == LinearSolver::cg_amg);
    EXPECT_GT(result.answer.residual, 0);
    EXPECT_LT(result.answer.residual, 1e-10);
    EXPECT_GT(result.answer.bytes, 135 * 81); // at least part of a matrix
    EXPECT_GT(result.answer.seconds.setup, 0);
    EXPECT_GT(result.answer.seconds.solve, 0);
  }
  EXPECT_EQ(fem_ref::solve(scene, options_of(2)).answer.method, "fem_q2");
}

TEST(SolversContract, AutomaticTakesTheFactorWhereItIsSmallAndSaysSo) {
  Scene small = test::box_scene(3, {8, 4, 4});
  test::hold_face(small, 0, false);
  test::move_face(small, 0, true, {1e-4, 0, 0});
  EXPECT_EQ(fem_ref::solve(small, options_of(1)).answer.algorithm.substr(0, 11), "Q1, CHOLMOD");

  Scene even = test::box_scene(3, {24, 24, 24});
  test::hold_face(even, 0, false);
  test::move_face(even, 0, true, {1e-4, 0, 0});
  const Answer by_meshes = fem_ref::solve(even, options_of(1)).answer;
  EXPECT_EQ(by_meshes.algorithm.substr(0, 44), "Q1, CG with geometric multigrid, matrix-free")
      << by_meshes.algorithm;
  EXPECT_EQ(by_meshes.status, Status::done);

  Scene large = test::box_scene(3, {27, 27, 27});
  test::hold_face(large, 0, false);
  test::move_face(large, 0, true, {1e-4, 0, 0});
  const Answer answer = fem_ref::solve(large, options_of(1)).answer;
  EXPECT_EQ(answer.algorithm.substr(0, 38), "Q1, CG with smoothed-aggregation AMG (") << answer.algorithm;
  EXPECT_EQ(answer.status, Status::done);
}

TEST(SolversContract, StopIsHeard) {
  const Scene scene = rich_scene(3);
  Control at_once;
  at_once.stop_requested = [] { return true; };
  const Answer early = fem_ref::solve(scene, options_of(1), at_once).answer;
  EXPECT_EQ(early.status, Status::interrupted);
  ASSERT_EQ(early.displacement.n_components(), 3u);
  // What is prescribed stands, nothing else has moved.
  EXPECT_DOUBLE_EQ(test::largest(early.displacement), 1e-3);

  Control while_iterating;
  int iterations = 0;
  while_iterating.progress = [&](double, std::string_view what) { iterations += what == "iterating"; };
  while_iterating.stop_requested = [&] { return iterations >= 3; };
  const Answer late = fem_ref::solve(scene, options_of(1, LinearSolver::cg_amg), while_iterating).answer;
  EXPECT_EQ(late.status, Status::interrupted);
  EXPECT_LE(late.iterations, 3);
  EXPECT_GT(late.residual, 1e-12);

  Control no_time;
  no_time.seconds_budget = 0;
  EXPECT_EQ(fem_ref::solve(scene, options_of(1), no_time).answer.status, Status::budget_reached);
}

TEST(SolversContract, ProgressRisesToOne) {
  for (const LinearSolver solver : {LinearSolver::cholmod, LinearSolver::cg_amg}) {
    std::vector<double> fractions;
    Control control;
    control.progress = [&](double fraction, std::string_view) { fractions.push_back(fraction); };
    fem_ref::solve(rich_scene(2), options_of(1, solver), control);
    ASSERT_GE(fractions.size(), 3u);
    EXPECT_TRUE(std::is_sorted(fractions.begin(), fractions.end()));
    EXPECT_EQ(fractions.back(), 1);
  }
}

// Truth: the same sums in another order.
TEST(SolversContract, ThreadsDoNotChangeTheAnswer) {
  const Scene scene = rich_scene(3);
  Control two;
  two.threads = 2;
  for (const LinearSolver solver : {LinearSolver::cholmod, LinearSolver::cg_amg}) {
    const Displacement one = fem_ref::solve(scene, options_of(2, solver)).answer.displacement;
    const Displacement other = fem_ref::solve(scene, options_of(2, solver), two).answer.displacement;
    EXPECT_LT(test::largest_difference(one, other), 1e-9 * test::largest(one));
  }
}

TEST(SolversContract, NothingIsPrinted) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  for (const LinearSolver solver : {LinearSolver::cholmod, LinearSolver::cg_amg})
    fem_ref::solve(rich_scene(3), options_of(1, solver));
  Scene free = test::box_scene(3, {2, 2, 2});
  fem_ref::solve(free, options_of(1));
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(SolversContract, ImpossibleRequestsAreRefused) {
  Scene scene = rich_scene(2);
  EXPECT_EQ(fem_ref::solve(scene, options_of(3)).answer.message,
            "expected elements of degree 1 or 2, found 3");
  std::fill(scene.specimen.material_id.begin(), scene.specimen.material_id.end(), no_material);
  EXPECT_EQ(fem_ref::solve(scene, options_of(1)).answer.message, "the specimen holds no matter");

  Scene vast = test::box_scene(3, {4000, 4000, 4000}); // 6e10 nodes: petabytes
  vast.prescribed = {{0, 0, 0, true}};
  const Answer answer = fem_ref::solve(vast, options_of(1)).answer;
  EXPECT_EQ(answer.status, Status::refused);
  EXPECT_EQ(answer.message.substr(0, 29), "matrix and solver need about ");
}

} // namespace
} // namespace maille
