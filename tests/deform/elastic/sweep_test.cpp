#include "oracle/sweep.hpp"

#include "feasible/limits.hpp"
#include "support/bodies/lattice_scenes.hpp"
#include "support/fields.hpp"
#include "support/kit.hpp"
#include "support/quadratic_program.hpp"

namespace maille::deform {

namespace {

using test::even_limits;
using test::face;
using test::hold;
using test::lattice_box;
using test::move;

constexpr double ulp = std::numeric_limits<double>::epsilon();

Scene chain(int n, double by, const NeighbourLimits& limits) {
  Scene scene = lattice_box({n}, limits);
  hold(scene, {0, 0, 0});
  move(scene, {n, 0, 0}, {by, 0, 0});
  return scene;
}

// ---- elastic, limits not active ----

TEST(SweepAnalytic, AChainTendsToTheRamp) {
  for (const int n : {2, 5, 20, 80})
    for (const double tolerance : {1e-2, 1e-4, 1e-8}) {
      Scene scene = chain(n, 0.75, even_limits(2, 0, 1));
      scene.relaxation.tolerance = tolerance;
      const Answer answer = solve_sweep(scene);
      EXPECT_EQ(answer.status, Status::done);
      EXPECT_EQ(answer.message, "");
      double error = 0;
      for (int k = 0; k <= n; ++k) // u = by k / n
        error = std::max(error, std::abs(answer.displacement(0, k) - 0.75 * k / n) / 0.75);
      EXPECT_LE(error, 1.2 * tolerance) << n << " links, " << answer.iterations << " sweeps";
      EXPECT_LE(answer.residual, tolerance);
    }
}

TEST(SweepAnalytic, SweepsGrowWithTheSquareOfTheLength) {
  // Gauss-Seidel on a chain contracts by cos^2(pi / n) a sweep (Young 1954), so twice the length takes four
  // times the sweeps.
  Scene scene = chain(40, 1, even_limits(2, 0, 1));
  const auto short_one = static_cast<double>(solve_sweep(scene).iterations);
  scene = chain(80, 1, even_limits(2, 0, 1));
  const auto long_one = static_cast<double>(solve_sweep(scene).iterations);
  EXPECT_NEAR(long_one / short_one, 4, 0.4);
}

/// The graph Laplacian of the body with the prescribed components eliminated, dense.
Displacement laplacian_solution(const Scene& scene, const LinkLimits& limits) {
  const Grid& grid = scene.specimen.grid;
  test::QuadraticProgram program = test::program_of(scene, scene.prescribed);
  for (std::size_t b = 0; b < program.values.n_components(); ++b)
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
      for (int axis = 0; axis < grid.dimension(); ++axis)
        if (limits.intervals(grid.node_at(node), axis))
          program.add_spring(b, node, node + grid.stride(axis), 1);
  return program.elastic();
}

/// A body with a hole and an overhang, pulled and sheared; limits far away.
Scene notched_body() {
  Scene scene = lattice_box({7, 5, 4}, even_limits(4, 0, 4));
  scene.specimen.material_id.assign(140, 0);
  for (int cell = 0; cell < 140; ++cell) {
    const Index3 at = scene.specimen.grid.cell_at(cell);
    if (at[0] >= 2 && at[0] <= 3 && at[1] >= 2)
      scene.specimen.material_id[static_cast<std::size_t>(cell)] = no_material;
  }
  for (const Index3& at : face(scene, 0, false))
    hold(scene, at);
  for (const Index3& at : face(scene, 0, true))
    move(scene, at, {0.5, -0.25, 0});
  return scene;
}

TEST(SweepOracle, EqualsTheDenseLaplacian) {
  for (const double tolerance : {1e-3, 1e-6}) {
    Scene scene = notched_body();
    scene.relaxation.tolerance = tolerance;
    const Answer answer = solve_sweep(scene);
    ASSERT_EQ(answer.status, Status::done);
    EXPECT_EQ(answer.message, "");
    const Displacement expected = laplacian_solution(scene, LinkLimits(scene));
    EXPECT_LE(test::largest_difference(answer.displacement, expected), 1.2 * tolerance * 0.5);
  }
}

// ---- elastic, limits active ----

TEST(SweepOracle, IsFeasibleAfterEverySweep) {
  for (unsigned seed = 1; seed <= 100; ++seed) {
    std::mt19937 random(seed);
    Scene scene = test::random_body(random);
    const LinkLimits limits(scene);
    const std::vector<Prescribed> clipped = clip(scene, limits).prescribed;
    for (const std::int64_t sweeps : {1, 2, 7, 1000}) {
      scene.relaxation.sweeps = sweeps;
      const Answer answer = solve_sweep(scene);
      EXPECT_LE(largest_violation(scene, limits, answer.displacement), 100 * ulp * 2) << "seed " << seed;
      for (const Prescribed& p : clipped)
        EXPECT_EQ(answer.displacement(p.component, p.node), p.value) << "seed " << seed;
    }
  }
}

TEST(SweepAnalytic, AChainWithOneShortLinkIsTheConstrainedRamp) {
  // Held at 0, pulled by 1; the first link gives 0.1 at most, so the four others share 0.9. Only one end of
  // the short link is free, so nothing jams.
  Scene scene = test::pulled_chain({0, 1, 1, 1, 1}, even_limits(1.1, 0.9, 0), even_limits(2, 0, 0), 1);
  scene.relaxation.tolerance = 1e-8;
  const Answer answer = solve_sweep(scene);
  EXPECT_EQ(answer.message, "");
  for (int k = 1; k <= 5; ++k)
    EXPECT_NEAR(answer.displacement(0, k), 0.1 + 0.9 * (k - 1) / 4, 2e-8);
}

TEST(SweepContract, SaysWhereRigidLinksJamIt) {
  // Nodes 2 and 3 are joined by a rigid link: `limits` leaves both at 0, and neither can go alone. At the
  // least energy the four other links share the pull, and both are at 0.5.
  Scene scene = test::pulled_chain({0, 0, 1, 0, 0}, even_limits(2, 0, 0), even_limits(1, 1, 0), 1);
  const Answer answer = solve_sweep(scene);
  EXPECT_EQ(answer.displacement(0, 2), 0);
  EXPECT_EQ(answer.displacement(0, 3), 0);
  // Nodes 1 and 4 have settled at 0 and 0.5, so the pair would go 0.25 further at first.
  EXPECT_NE(answer.message.find("jammed: 1 groups"), std::string::npos) << answer.message;
  EXPECT_NE(answer.message.find("the most by 0.25 m"), std::string::npos) << answer.message;
}

TEST(SweepContract, SaysWhereActiveLimitsJamIt) {
  // No link is rigid, but the middle one gives 0.125 only. `limits` leaves its ends at 0.75 and 0.875; they
  // want to part and hold each other; the outer links pull the pair by (-0.75 + 1) / 2 on.
  Scene scene = test::pulled_chain({0, 1, 0}, even_limits(2, 0, 0), even_limits(1.125, 0.875, 0), 1.875);
  const Answer answer = solve_sweep(scene);
  EXPECT_NEAR(answer.displacement(0, 1), 0.75, 1e-12);
  EXPECT_NEAR(answer.displacement(0, 2), 0.875, 1e-12);
  EXPECT_NE(answer.message.find("jammed: 1 groups"), std::string::npos) << answer.message;
  EXPECT_NE(answer.message.find("the most by 0.125 m"), std::string::npos) << answer.message;
}

TEST(SweepContract, AnImpossibleRequestIsCutAsLimitsCutsIt) {
  Scene scene = chain(10, 9, even_limits(1.25, 0.75, 0));
  const Answer answer = solve_sweep(scene);
  EXPECT_EQ(answer.status, Status::clamped);
  EXPECT_EQ(answer.displacement(0, 10), 2.5);
  EXPECT_EQ(answer.message, solve_limits(scene).message);
}

// ---- deformable ----

TEST(SweepDeformableAnalytic, AStateWithinTheLimitsStays) {
  Scene scene = lattice_box({4, 4, 4}, even_limits(1.25, 0.75, 0.25));
  scene.relaxation.mode = RelaxationMode::deformable;
  move(scene, {2, 2, 2}, {0.25, -0.125, 0.25});
  std::mt19937 random(5);
  Displacement start(scene.specimen.grid);
  for (double& u : start.values())
    u = static_cast<double>(random() % 9) / 64; // differences below the slack of 16 / 64
  for (const Prescribed& p : scene.prescribed)
    start(p.component, p.node) = 0.0625;
  Scene still = scene;
  for (Prescribed& p : still.prescribed)
    p.value = 0.0625;
  const Answer answer = relax_sweep(still, LinkLimits(still), start);
  EXPECT_EQ(answer.displacement, start);
  EXPECT_EQ(answer.iterations, 1);
}

TEST(SweepDeformableAnalytic, AChainStopsAtTheEdgeOfItsDeadZone) {
  // Pulled by 1 with 0.25 slack a link: as in `limits`, 1, 0.75, 0.5, 0.25, 0, 0, ... is feasible, and nodes
  // only ever move as far as they must, so no node gets beyond it.
  Scene scene = lattice_box({12}, even_limits(1.25, 0.75, 0));
  scene.relaxation.mode = RelaxationMode::deformable;
  scene.relaxation.tolerance = 1e-6;
  move(scene, {12, 0, 0}, {1, 0, 0});
  const Answer answer = solve_sweep(scene);
  EXPECT_EQ(answer.status, Status::done);
  EXPECT_EQ(answer.message, "");
  for (int k = 0; k <= 12; ++k) {
    EXPECT_GE(answer.displacement(0, k), std::max(0.0, 1 - 0.25 * (12 - k)) - 2e-6);
    EXPECT_LE(answer.displacement(0, k), 1);
  }
  EXPECT_LE(largest_violation(scene, LinkLimits(scene), answer.displacement), 2e-6);
}

TEST(SweepDeformableContract, EndsFeasibleOnRandomBodies) {
  for (unsigned seed = 1; seed <= 100; ++seed) {
    std::mt19937 random(seed);
    Scene scene = test::random_body(random);
    scene.relaxation.mode = RelaxationMode::deformable;
    scene.relaxation.tolerance = 1e-6;
    const Answer answer = solve_sweep(scene);
    EXPECT_TRUE(answer.status == Status::done || answer.status == Status::clamped) << "seed " << seed;
    const double largest = scene.largest_prescribed();
    // Rest lengths are 0.5 at least.
    EXPECT_LE(largest_violation(scene, LinkLimits(scene), answer.displacement), 3e-6 * largest / 0.5)
        << "seed " << seed << " " << answer.message;
  }
}

// ---- steering ----

TEST(SweepContract, EndsAtItsBudgetOfSweeps) {
  Scene scene = notched_body();
  scene.relaxation.sweeps = 20;
  const Answer answer = solve_sweep(scene);
  EXPECT_EQ(answer.status, Status::budget_reached);
  EXPECT_EQ(answer.iterations, 20);
  EXPECT_GT(answer.residual, scene.relaxation.tolerance);
  scene.relaxation.sweeps = 3; // too few to say anything
  EXPECT_EQ(solve_sweep(scene).residual, 1);
}

TEST(SweepContract, StopsBetweenSweepsWhenAsked) {
  Control control;
  int polls = 0, reports = 0;
  control.stop_requested = [&] { return ++polls > 5; };
  control.progress = [&](double fraction, std::string_view) {
    ++reports;
    EXPECT_GE(fraction, 0);
    EXPECT_LE(fraction, 1);
  };
  const Answer answer = solve_sweep(notched_body(), control);
  EXPECT_EQ(answer.status, Status::interrupted);
  EXPECT_EQ(answer.iterations, 5);
  EXPECT_GE(reports, 1);
}

TEST(SweepContract, AComponentThatNothingMovesStaysAtRest) {
  const Answer answer = solve_sweep(notched_body());
  for (const double u : answer.displacement.component(2))
    EXPECT_EQ(u, 0);
}

TEST(ErrorEstimateAnalytic, IsTheSumOfAGeometricSeries) {
  for (const double rho : {0.5, 0.99, 0.99999}) {
    ErrorEstimate estimate(0);
    double change = 1;
    for (int k = 0; k < 400; ++k, change *= rho)
      estimate.add(change);
    const double rest = change / (1 - rho); // change * (1 + rho + rho^2 + ...)
    EXPECT_NEAR(estimate.remaining() / rest, 1, 1e-9) << rho;
  }
}

TEST(ErrorEstimateAnalytic, NothingCanBeSaidWhileChangesDoNotShrink) {
  ErrorEstimate estimate(0);
  for (int k = 0; k < 100; ++k)
    estimate.add(1.0);
  EXPECT_TRUE(std::isinf(estimate.remaining()));
  estimate.add(0);
  EXPECT_EQ(estimate.remaining(), 0);
}

TEST(ErrorEstimateAnalytic, SlowModesCountMoreThanFastOnes) {
  // 0.5^k + 1e-6 0.999^k: after the fast mode has gone the slow one has 1e-3 left to go.
  ErrorEstimate estimate(0);
  for (int k = 0; k < 300; ++k)
    estimate.add(std::pow(0.5, k) + 1e-6 * std::pow(0.999, k));
  EXPECT_NEAR(estimate.remaining() / (1e-6 * std::pow(0.999, 300) / 0.001), 1, 0.01);
}

TEST(ErrorEstimateAnalytic, RoundingNoiseDoesNotUndoWhatWasKnown) {
  ErrorEstimate estimate(1e-15);
  for (double change = 1; change > 1e-15; change *= 0.9)
    estimate.add(change);
  const double known = estimate.remaining();
  for (int k = 0; k < 50; ++k)
    estimate.add(k % 2 == 0 ? 1e-16 : 2e-16);
  EXPECT_LE(estimate.remaining(), known);
}

} // namespace

} // namespace maille::deform
