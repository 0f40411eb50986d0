#include "feasible/wavefront/wavefront.hpp"

#include "support/bodies/holed_bodies.hpp"
#include "support/quanta.hpp"
#include "support/tiled_state.hpp"
#include "support/worlds/all_paths.hpp"

#include <gtest/gtest.h>

namespace maille::deform {
namespace {

using tests::Dice;
using tests::largest_quantum;
using tests::state_of;

// ---- the nearest feasible state ----

TEST(WavefrontProjectionOracle, NoFeasibleStateIsNearerInTheLargestDifference) {
  // Theorem 5: the distance is half the largest amount by which two values contradict each other.
  for (unsigned seed = 1; seed <= 150; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    Dice dice{random};
    Scene scene = tests::random_body(random);
    const LinkLimits limits(scene);
    Displacement wanted(scene.specimen.grid);
    for (const std::int64_t node : tests::matter_nodes(scene))
      for (int b = 0; b < scene.dimension(); ++b)
        wanted(b, node) = 2 * dice.uniform() - 1;
    TiledBody body(scene, limits);
    const double change = body.set_state(wanted);
    const Displacement projected = state_of(scene, body);
    const double q = largest_quantum(scene, body);
    EXPECT_LE(tests::worst_violation(scene, limits, projected, q), 1.001);
    double nearest = 0;
    for (int b = 0; b < scene.dimension(); ++b) {
      const tests::AllPaths paths(scene, limits, b);
      for (const std::int64_t i : tests::matter_nodes(scene))
        for (const std::int64_t j : tests::matter_nodes(scene))
          nearest = std::max(nearest, (wanted(b, j) - wanted(b, i) - paths(i, j)) / 2);
    }
    EXPECT_NEAR(change, nearest, (tests::longest_path(scene) + 2) * q);
    for (int b = 0; b < scene.dimension(); ++b)
      for (const std::int64_t node : tests::matter_nodes(scene))
        EXPECT_LE(std::abs(projected(b, node) - wanted(b, node)), change + 2 * q);
  }
}

TEST(WavefrontProjectionContract, AFeasibleStateIsTakenAsItIs) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    std::mt19937 random(seed);
    const Scene scene = tests::holed_body(random);
    const LinkLimits limits(scene);
    TiledBody body(scene, limits), other(scene, limits);
    body.move(scene.prescribed);
    body.raise(0, {}); // what was prescribed is no longer shown at its exact value, but in whole quanta
    const Displacement state = state_of(scene, body);
    // A body whose quanta have grown on the way is feasible in those, which are coarser.
    bool has_grown = false;
    for (int b = 0; b < scene.dimension(); ++b)
      has_grown = has_grown || other.quantum(b) != body.quantum(b);
    EXPECT_LE(other.set_state(state),
              has_grown ? tests::longest_path(scene) * largest_quantum(scene, body) : 0)
        << "seed " << seed;
    for (std::size_t b = 0; b < state.n_components(); ++b)
      if (other.quantum(static_cast<int>(b)) == body.quantum(static_cast<int>(b))) {
        EXPECT_TRUE(std::ranges::equal(state_of(scene, other).component(b), state.component(b)))
            << "seed " << seed;
      }
  }
}

// ---- envelopes ----

TEST(WavefrontPathsOracle, AreThoseOfDijkstraWithinTheirBound) {
  for (unsigned seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    Dice dice{random};
    const Scene scene = tests::holed_body(random);
    const LinkLimits limits(scene);
    const std::vector<std::int64_t> nodes = tests::matter_nodes(scene);
    std::vector<PathEnd> ends;
    double low = 1e300, high = -1e300;
    for (int i = 1 + dice.below(5); i > 0; --i) {
      ends.push_back({nodes[static_cast<std::size_t>(dice.below(static_cast<int>(nodes.size())))],
                      10 * dice.uniform() - 5});
      low = std::min(low, ends.back().potential);
      high = std::max(high, ends.back().potential);
    }
    const int component = dice.below(scene.dimension());
    for (const PathDirection direction : {PathDirection::from_ends, PathDirection::to_ends}) {
      const auto expected = shortest_paths(scene, limits, component, ends, direction);
      const auto found = wavefront_paths(scene, limits, component, ends, direction);
      double longest = high;
      for (const double length : expected)
        longest = std::isfinite(length) ? std::max(longest, length) : longest;
      // A quantum is 2^-28 of what is spanned at most, and no path visits a node twice.
      const double slack = 0.9 * 2 * 40 * 3 + 2 * (longest - low);
      const double bound = (tests::longest_path(scene) + 2) * slack * 0x1p-28;
      ASSERT_EQ(found.size(), expected.size());
      for (std::size_t n = 0; n < found.size(); ++n) {
        ASSERT_EQ(std::isfinite(found[n]), std::isfinite(expected[n])) << n;
        if (std::isfinite(found[n])) {
          ASSERT_NEAR(found[n], expected[n], bound) << n;
        }
      }
    }
  }
}

TEST(WavefrontPathsAnalytic, NoEndsReachNothing) {
  const Scene scene = tests::lattice_box({3, 2}, tests::even_limits(1.5, 0.5, 0.25));
  const LinkLimits limits(scene);
  for (const double length : wavefront_paths(scene, limits, 0, {}, PathDirection::from_ends))
    EXPECT_EQ(length, std::numeric_limits<double>::infinity());
}

} // namespace
} // namespace maille::deform
