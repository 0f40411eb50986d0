#include "feasible/limits.hpp"

#include "support/bodies/lattice_scenes.hpp"
#include "support/worlds/all_paths.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace maille::deform {
namespace {

using tests::AllPaths;
using tests::even_limits;
using tests::hold;
using tests::lattice_box;
using tests::move;

constexpr double ulp = std::numeric_limits<double>::epsilon();

TEST(ClippingAnalytic, AHeldChainEndsWhereItsSlackEnds) {
  for (const double by : {1e-300, 2.5, 1e300, -1.25, -1e300}) {
    Scene scene = lattice_box({10}, even_limits(1.25, 0.875, 0));
    hold(scene, {0, 0, 0});
    move(scene, {10, 0, 0}, {by, 0, 0});
    const double end = std::clamp(by, -10 * 0.125, 10 * 0.25); // ten links' slack, exactly
    const Answer answer = solve_limits(scene);
    EXPECT_EQ(answer.displacement(0, 10), end);
    EXPECT_EQ(answer.displacement(0, 0), 0);
    EXPECT_EQ(answer.status, end == by ? Status::done : Status::clamped);
    EXPECT_EQ(answer.message.empty(), end == by) << answer.message;
    for (int n = 0; end != by && n <= 10; ++n) // a taut chain is a ramp
      EXPECT_EQ(answer.displacement(0, n), end * n / 10);
  }
}

TEST(ClippingContract, TheMessageSaysHowManyHowMuchAndWhere) {
  Scene scene = lattice_box({4, 2}, even_limits(1.25, 0.75, 0.25));
  scene.specimen.grid = Grid(2, {4, 2, 1}, {0.5, 0.5, 1});
  scene.specimen.origin = {1, 2, 0};
  hold(scene, {0, 0, 0});
  move(scene, {4, 0, 0}, {0.25, 0, 0});
  move(scene, {4, 2, 0}, {0, 1.5, 0}); // 4 links sheared and 2 stretched, 0.125 each
  // The hold leaves (4, 2) at most 0.75 along y; (4, 0), asked to stay, at most 0.25 from it: 0.5 too much,
  // so they meet at 0.25 and 0.5.
  const Answer answer = solve_limits(scene);
  EXPECT_EQ(answer.status, Status::clamped);
  EXPECT_EQ(answer.message,
            "the limits permit only part of 2 of 4 moved components: the largest cut is 1 m, "
            "along y at the node at (3, 3, 0) m; [limits] cut = \"allowed\" would take that for an answer");
  EXPECT_EQ(answer.displacement(1, scene.specimen.grid.node({4, 0, 0})), 0.25);
  EXPECT_EQ(answer.displacement(1, scene.specimen.grid.node({4, 2, 0})), 0.5);
}

TEST(ClippingAnalytic, ContradictoryMovesMeetHalfWay) {
  // Ten links stretch by 0.25 each: 2.5 in all, asked for 4 + 2 = 6, so each end gives 1.75 back.
  Scene scene = lattice_box({10}, even_limits(1.25, 0.75, 0));
  move(scene, {0, 0, 0}, {-4, 0, 0});
  move(scene, {10, 0, 0}, {2, 0, 0});
  const Clipping clipping = clip(scene, LinkLimits(scene));
  EXPECT_EQ(clipping.n_cut, 2);
  EXPECT_EQ(clipping.largest_cut, 1.75);
  EXPECT_EQ(clipping.prescribed[0].value, -2.25);
  EXPECT_EQ(clipping.prescribed[1].value, 0.25);
}

TEST(ClippingAnalytic, MirroredRequestsGetMirroredAnswers) {
  Scene scene = lattice_box({7, 7}, even_limits(1.25, 0.75, 0.125));
  hold(scene, {3, 3, 0});
  move(scene, {0, 0, 0}, {-9, -9, 0});
  move(scene, {7, 7, 0}, {9, 9, 0});
  move(scene, {7, 0, 0}, {9, -9, 0});
  move(scene, {0, 7, 0}, {-9, 9, 0});
  const Answer answer = solve_limits(scene);
  EXPECT_EQ(answer.status, Status::clamped);
  // Exchanging x and y maps the scene onto itself.
  const Grid& grid = scene.specimen.grid;
  for (std::int64_t n = 0; n < grid.n_nodes(); ++n) {
    const Index3 at = grid.node_at(n);
    EXPECT_EQ(answer.displacement(0, n), answer.displacement(1, grid.node({at[1], at[0], 0})));
  }
}

TEST(ClippingAnalytic, RequestsThatCanBeMetAreKeptToTheBit) {
  // A taut scene asks for exactly what its slack allows; its sums are rounded, the request is not cut.
  for (const int n : {3, 7, 100, 3001}) {
    Scene scene = lattice_box({n}, {});
    scene.limits = {};
    hold(scene, {0, 0, 0});
    move(scene, {n, 0, 0}, {0.1, 0, 0});
    const Answer answer = solve_limits(scene);
    EXPECT_EQ(answer.status, Status::done) << n << answer.message;
    EXPECT_EQ(answer.displacement(0, n), 0.1);
  }
}

TEST(ClippingAnalytic, ARequestJustBeyondRoundingIsCut) {
  Scene scene = lattice_box({10}, even_limits(1.25, 0.75, 0));
  hold(scene, {0, 0, 0});
  move(scene, {10, 0, 0}, {2.5 * (1 + 1e-13), 0, 0});
  EXPECT_EQ(solve_limits(scene).status, Status::clamped);
  move(scene, {10, 0, 0}, {2.5 * (1 + 1e-15), 0, 0}); // within the stated 20 half-ulps of ten links
  EXPECT_EQ(solve_limits(scene).status, Status::done);
}

/// What clip_component promises, pair by pair.
void expect_nearest(const Scene& scene, const LinkLimits& limits, int component, const Clipping& clipping) {
  const AllPaths paths(scene, limits, component);
  std::vector<Prescribed> requested, clipped, holds;
  for (std::size_t i = 0; i < scene.prescribed.size(); ++i) {
    if (scene.prescribed[i].component != component)
      continue;
    requested.push_back(scene.prescribed[i]);
    clipped.push_back(clipping.prescribed[i]);
    if (scene.prescribed[i].held)
      holds.push_back(scene.prescribed[i]);
  }
  EXPECT_LE(paths.worst_contradiction(clipped), 200 * ulp);
  // The nearest feasible values to requests cut at the holds miss them by half the worst contradiction.
  std::vector<Prescribed> within_holds = requested;
  for (Prescribed& p : within_holds)
    p.value = std::min(std::max(p.value, paths.lowest(holds, p.node)), paths.highest(holds, p.node));
  double largest_change = 0;
  for (std::size_t i = 0; i < clipped.size(); ++i) {
    const double change = std::abs(clipped[i].value - within_holds[i].value);
    largest_change = std::max(largest_change, change);
    if (requested[i].held) {
      EXPECT_EQ(clipped[i].value, 0);
    }
  }
  std::vector<Prescribed> moves = within_holds;
  std::erase_if(moves, [](const Prescribed& p) { return p.held; });
  EXPECT_NEAR(largest_change, 0.5 * std::max(0.0, paths.worst_contradiction(moves)), 200 * ulp);
}

TEST(ClippingOracle, IsFeasibleAndNearestOnRandomBodies) {
  int n_cut = 0;
  for (unsigned seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    const Scene scene = tests::random_body(random);
    const LinkLimits limits(scene);
    const Clipping clipping = clip(scene, limits);
    n_cut += clipping.n_cut > 0 ? 1 : 0;
    for (int b = 0; b < scene.dimension(); ++b)
      expect_nearest(scene, limits, b, clipping);
  }
  EXPECT_GE(n_cut, 50);
}

} // namespace
} // namespace maille::deform
