#include "feasible/feasible_set.hpp"

#include "feasible/limits.hpp"
#include "support/bodies/lattice_scenes.hpp"
#include "support/fields.hpp"
#include "support/vector_targets.hpp"
#include "support/worlds/all_paths.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace maille::deform {
namespace {

using tests::below;
using tests::even_limits;
using tests::ForcedVectors;
using tests::lattice_box;
using tests::random_box;
using tests::vector_targets;

Displacement noise(std::mt19937& random, const Scene& scene) {
  Displacement state(scene.specimen.grid);
  for (int b = 0; b < scene.dimension(); ++b)
    for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node)
      if (scene.specimen.is_node(scene.specimen.grid.node_at(node)))
        state(b, node) = tests::random_dyadic(random, 2)[0];
  return state;
}

/// The obvious way: majorant and minorant over all pairs of nodes.
Displacement projected_by_pairs(const Scene& scene, const Displacement& state) {
  const LinkLimits limits(scene);
  Displacement projected = state;
  for (int b = 0; b < scene.dimension(); ++b) {
    const tests::AllPaths paths(scene, limits, b);
    std::vector<Prescribed> ends;
    for (std::int64_t n = 0; n < scene.specimen.grid.n_nodes(); ++n)
      if (scene.specimen.is_node(scene.specimen.grid.node_at(n)))
        ends.push_back({n, b, state(b, n), false});
    for (const Prescribed& p : ends)
      projected(b, p.node) = 0.5 * paths.lowest(ends, p.node) + 0.5 * paths.highest(ends, p.node);
  }
  return projected;
}

TEST(ProjectionOracle, EqualsAllPairsToTheBitForEveryVectorAndThreadCount) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    std::mt19937 random(seed);
    Scene scene = lattice_box({1}, tests::random_dyadic_limits(random));
    scene.specimen.grid =
        Grid(3, {1 + below(random, 20), 1 + below(random, 9), 1 + below(random, 2)}, {1, 1, 1});
    const LinkLimits limits(scene);
    const Displacement state = noise(random, scene), expected = projected_by_pairs(scene, state);
    for (const std::int64_t target : vector_targets()) {
      const ForcedVectors forced(target);
      for (const int threads : {1, 3}) {
        Displacement projected = state;
        EXPECT_EQ(FeasibleSet(scene, limits, threads).project(projected),
                  test::largest_difference(state, expected));
        ASSERT_EQ(projected, expected) << "seed " << seed;
        Body body(scene); // float32 holds these numbers exactly
        body.set_displacement(state);
        EXPECT_EQ(FeasibleSet(body.scene(), limits, threads).project(body),
                  test::largest_difference(state, expected));
        ASSERT_EQ(body.displacement(), expected) << "seed " << seed;
      }
    }
  }
}

TEST(ProjectionOracle, IsNearestOnBodiesOfAnyKind) {
  for (unsigned seed = 1; seed <= 100; ++seed) {
    std::mt19937 random(seed);
    Scene scene = tests::random_body(random);
    const LinkLimits limits(scene);
    Displacement projected = noise(random, scene);
    const Displacement expected = projected_by_pairs(scene, projected);
    FeasibleSet(scene, limits).project(projected);
    for (std::size_t i = 0; i < projected.values().size(); ++i)
      EXPECT_NEAR(projected.values()[i], expected.values()[i], 200 * std::numeric_limits<double>::epsilon());
    EXPECT_LE(largest_violation(scene, limits, projected), 400 * std::numeric_limits<double>::epsilon());
  }
}

TEST(ProjectionAnalytic, AFeasibleStateStays) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    std::mt19937 random(seed);
    Scene scene = random_box(random, 1 + below(random, 3));
    for (int k = 0; k < 3; ++k)
      tests::move(scene, tests::random_node(random, scene.specimen.grid), tests::random_dyadic(random, 4));
    const Displacement feasible = solve_limits(scene).displacement;
    Displacement state = feasible;
    EXPECT_EQ(FeasibleSet(scene, LinkLimits(scene)).project(state), 0);
    EXPECT_EQ(state, feasible) << "seed " << seed;
  }
}

TEST(ProjectionAnalytic, OneNodeThatIsTooFarMeetsItsNeighboursHalfWay) {
  // A node 2 ahead of neighbours that allow 0.5: 1.5 too far, so it goes back 0.75 and all others come 0.75
  // less what the links between take up.
  Scene scene = lattice_box({6}, even_limits(1.5, 0.5, 0));
  Displacement state(scene.specimen.grid);
  state(0, 3) = 2;
  EXPECT_EQ(FeasibleSet(scene, LinkLimits(scene)).project(state), 0.75);
  EXPECT_TRUE(
      std::ranges::equal(state.component(0), (std::vector<double>{0.25, 0.5, 0.75, 1.25, 0.75, 0.5, 0.25})));
}

TEST(ProjectionContract, SameBitsForEveryVectorAndThreadCountThoughSumsAreRounded) {
  const Scene scene = lattice_box({41, 37, 33}, even_limits(1.23456, 0.87654, 0.1357));
  const LinkLimits limits(scene);
  std::mt19937 random(9);
  Body noisy(scene), first(scene);
  const Displacement state = noise(random, scene);
  first.set_displacement(state);
  FeasibleSet(first.scene(), limits).project(first);
  // Values are below 2, where half an ulp of float32 is 2^-24; a link compares two sums of 111 steps or less.
  EXPECT_LE(largest_violation(scene, limits, first.displacement()), 2 * 114 * std::ldexp(1.0, -24));
  for (const std::int64_t target : vector_targets()) {
    const ForcedVectors forced(target);
    for (const int threads : {1, 2, 3, 7}) {
      noisy.set_displacement(state);
      FeasibleSet(noisy.scene(), limits, threads).project(noisy);
      ASSERT_EQ(noisy.displacement(), first.displacement())
          << hwy::TargetName(target) << " threads " << threads;
    }
  }
}

TEST(ProjectionContract, ALargeInhomogeneousBodyGoesByTheWavefront) {
  Scene scene = lattice_box({20, 15, 13}, even_limits(1.25, 0.75, 0.25));
  scene.specimen.material_id.assign(20 * 15 * 13, 0);
  for (int k = 0; k < 300; ++k)
    scene.specimen.material_id[static_cast<std::size_t>(k * 13)] = no_material;
  std::mt19937 random(3);
  Displacement projected = noise(random, scene), expected = projected;
  const LinkLimits limits(scene);
  const double change = FeasibleSet(scene, limits).project(projected);
  EXPECT_GT(change, 0.5);
  // Quanta are at most 2^-29 of the slack across the grid, 24.
  EXPECT_LE(largest_violation(scene, limits, projected), 3 * 24 * std::ldexp(1.0, -29));
  EXPECT_NEAR(test::largest_difference(projected, expected), change, 4 * 24 * std::ldexp(1.0, -29));
}

} // namespace
} // namespace maille::deform
