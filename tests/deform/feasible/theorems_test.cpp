/// The theorems that propagation rests on (docs/theory.md, section 1), each checked on what the product does.
///
/// 1  the clamp moves every node least              here
/// 2  closed form on voxel sets reached monotonely  here, and closed_form_test.cpp
/// 3  what changes is closed toward the handle      here, and closed_form_test.cpp
/// 4  many handles: which can be met, and intervals here, and clipping_test.cpp, separable_scans_test.cpp
/// 5  projection                                        projection_test.cpp, wavefront_projection_test.cpp
/// 6  paths of a drag                               here, and drag_test.cpp, wavefront_drag_test.cpp

#include "feasible/bounds/bound_source.hpp"
#include "feasible/limits.hpp"
#include "maille/deform/drag.hpp"
#include "maille/deform/plan.hpp"
#include "maille/deform/solve.hpp"
#include "support/bodies/lattice_scenes.hpp"
#include "support/fields.hpp"
#include "support/worlds/all_paths.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace maille::deform {
namespace {

using tests::AllPaths;
using tests::below;
using tests::random_dyadic;
using tests::random_node;

/// A feasible state: handles pulled one after the other. Dyadic.
Displacement feasible_state(std::mt19937& random, const Scene& scene, const LinkLimits& limits) {
  Displacement state(scene.specimen.grid);
  for (int k = 0; k < 3; ++k) {
    Scene step = scene;
    step.prescribed.clear();
    tests::move(step, random_node(random, scene.specimen.grid), random_dyadic(random, 3));
    state = drag_limits(step, limits, state).displacement;
  }
  return state;
}

Scene small_box(std::mt19937& random) {
  Scene scene = tests::lattice_box({1}, tests::random_dyadic_limits(random));
  scene.specimen.grid =
      Grid(3, {1 + below(random, 5), 1 + below(random, 4), 1 + below(random, 3)}, {1, 1, 1});
  return scene;
}

TEST(Theorem1Oracle, NoFeasibleStateWithTheHandleThereMovesAnyNodeLess) {
  // Rivals: the clamped state of any other feasible state is one with the handle in place; none is nearer, at
  // any node.
  for (unsigned seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    Scene scene = small_box(random);
    const LinkLimits limits(scene);
    const Displacement start = feasible_state(random, scene, limits);
    const Index3 handle = random_node(random, scene.specimen.grid);
    tests::move(scene, handle, random_dyadic(random, 4));
    const Displacement least = drag_limits(scene, limits, start).displacement;
    EXPECT_EQ(largest_violation(scene, limits, least), 0);
    for (int rival = 0; rival < 8; ++rival) {
      const Displacement other =
          drag_limits(scene, limits, feasible_state(random, scene, limits)).displacement;
      ASSERT_EQ(largest_violation(scene, limits, other), 0);
      for (std::size_t i = 0; i < least.values().size(); ++i)
        ASSERT_LE(std::abs(least.values()[i] - start.values()[i]),
                  std::abs(other.values()[i] - start.values()[i]));
    }
  }
}

TEST(Theorem2Oracle, OnVoxelSetsReachedMonotonelyTheClosedFormIsTheShortestPath) {
  // Growing sets: a cell may join if it lies next to one that is nearer to the corner. Up to 10 x 9 x 8
  // cells.
  int n_reached = 0;
  for (unsigned seed = 1; seed <= 120; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    Scene scene = tests::lattice_box({1}, tests::random_dyadic_limits(random));
    scene.specimen.grid =
        Grid(3, {2 + below(random, 9), 2 + below(random, 8), 2 + below(random, 7)}, {1, 1, 1});
    const Grid& grid = scene.specimen.grid;
    auto& kinds = scene.specimen.material_id;
    kinds.assign(static_cast<std::size_t>(grid.n_cells()), no_material);
    kinds[0] = 0;
    for (std::int64_t cell = 1; cell < grid.n_cells(); ++cell) {
      const Index3 at = grid.cell_at(cell);
      for (std::size_t a = 0; a < 3; ++a)
        if (Index3 before = at; --before[a] >= 0 && kinds[static_cast<std::size_t>(grid.cell(before))] == 0 &&
                                below(random, 3) != 0)
          kinds[static_cast<std::size_t>(cell)] = 0;
    }
    const Index3 handle{0, 0, 0};
    if (!reaches_all_monotonely(scene.specimen, handle))
      continue;
    ++n_reached;
    const Vec3 by = random_dyadic(random, 8);
    tests::move(scene, handle, by);
    const Answer expected = solve(scene, "dijkstra"), answer = solve(scene, "limits");
    EXPECT_TRUE(answer.algorithm.starts_with("closed form") || by == Vec3{}) << answer.algorithm;
    ASSERT_EQ(answer.displacement, expected.displacement);
  }
  EXPECT_GE(n_reached, 60);
}

TEST(Theorem3Oracle, WhatChangesIsClosedTowardTheHandleAndVisitsFollowIt) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    const Scene scene = tests::random_box(random, 3);
    const LinkLimits limits(scene);
    const Grid& grid = scene.specimen.grid;
    Drag drag(scene, limits, 1, FrameRule::fixed); // the theorem is about one frame
    for (int k = 0; k < 4; ++k)
      drag.move_to(grid.node(random_node(random, grid)), random_dyadic(random, 3));
    const Displacement before = drag.displacement();
    const Index3 handle = random_node(random, grid);
    const std::int64_t visited = drag.move_to(grid.node(handle), random_dyadic(random, 3)).visited;
    const Displacement after = drag.displacement();
    std::int64_t moved = 0;
    for (int b = 0; b < 3; ++b)
      for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
        if (before(b, node) == after(b, node))
          continue;
        ++moved;
        const Index3 at = grid.node_at(node);
        for (std::size_t a = 0; a < 3; ++a) // the next node on every monotone path home has moved, too
          if (at[a] != handle[a]) {
            Index3 nearer = at;
            nearer[a] += at[a] < handle[a] ? 1 : -1;
            ASSERT_NE(before(b, grid.node(nearer)), after(b, grid.node(nearer)));
          }
      }
    EXPECT_GE(visited, moved);
  }
}

TEST(Theorem4Oracle, HandlesCanBeMetIfAndOnlyIfNoPairAsksForMoreThanItsShortestPath) {
  int n_met = 0, n_cut = 0;
  for (unsigned seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    Scene scene = small_box(random);
    for (int k = 1 + below(random, 5); k >= 0; --k)
      tests::prescribe(scene, scene.specimen.grid.node(random_node(random, scene.specimen.grid)),
                       below(random, 3), random_dyadic(random, 1)[0] / 2, below(random, 4) == 0 && k > 0);
    for (Prescribed& p : scene.prescribed)
      p.value = p.held ? 0 : p.value;
    const LinkLimits limits(scene);
    bool can_be_met = true;
    for (int b = 0; b < 3; ++b) {
      const AllPaths paths(scene, limits, b);
      for (const Prescribed& g : scene.prescribed)
        for (const Prescribed& h : scene.prescribed) // p_h - p_g <= d(g, h)
          if (g.component == b && h.component == b)
            can_be_met = can_be_met && h.value <= paths.highest({g}, h.node);
    }
    (can_be_met ? n_met : n_cut)++;
    EXPECT_EQ(solve(scene, "limits").status, can_be_met ? Status::done : Status::clamped);
  }
  EXPECT_GE(n_met, 50);
  EXPECT_GE(n_cut, 50);
}

TEST(Theorem4Oracle, OneRequestIsClampedIntoTheIntervalThatHoldsLeaveIt) {
  int n_cut = 0;
  for (unsigned seed = 1; seed <= 100; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    Scene scene = small_box(random);
    for (int k = 0; k < 3; ++k)
      tests::hold(scene, random_node(random, scene.specimen.grid));
    const std::int64_t node = scene.specimen.grid.node(random_node(random, scene.specimen.grid));
    if (std::ranges::count(scene.prescribed, node, &Prescribed::node) > 0)
      continue;
    const LinkLimits limits(scene);
    const Vec3 request = random_dyadic(random, 3);
    const Vec3 clipped = Drag(scene, limits).move_to(node, request).displacement;
    for (int b = 0; b < 3; ++b) {
      const AllPaths paths(scene, limits, b);
      std::vector<Prescribed> holds = scene.prescribed;
      std::erase_if(holds, [&](const Prescribed& p) { return p.component != b; });
      const auto i = static_cast<std::size_t>(b);
      const double expected =
          std::min(std::max(request[i], paths.lowest(holds, node)), paths.highest(holds, node));
      EXPECT_EQ(clipped[i], expected);
      n_cut += expected != request[i] ? 1 : 0;
    }
  }
  EXPECT_GE(n_cut, 50);
}

TEST(Theorem6Oracle, MonotonePathsEndTheSameAndTheWayBackLeavesWhatDijkstraLeaves) {
  int n_left = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    const Scene scene = small_box(random);
    const LinkLimits limits(scene);
    const std::int64_t node = scene.specimen.grid.node(random_node(random, scene.specimen.grid));
    const Vec3 to = random_dyadic(random, 4);
    Drag at_once(scene, limits), in_steps(scene, limits);
    at_once.move_to(node, to);
    for (int k = 1; k <= 1024; ++k) // dyadic steps
      in_steps.move_to(node, {to[0] * k / 1024, to[1] * k / 1024, to[2] * k / 1024});
    ASSERT_EQ(in_steps.displacement(), at_once.displacement());
    at_once.move_to(node, {0, 0, 0});
    Displacement expected(scene.specimen.grid);
    for (const Vec3& place : {to, Vec3{0, 0, 0}}) {
      Scene step = scene;
      tests::move(step, scene.specimen.grid.node_at(node), place);
      expected = drag_limits(step, limits, expected).displacement;
    }
    ASSERT_EQ(at_once.displacement(), expected);
    const double largest = test::largest(expected);
    EXPECT_EQ(at_once.residue().largest, largest);
    n_left += largest > 0 ? 1 : 0;
  }
  EXPECT_GE(n_left, 3); // the model is plastic
}

} // namespace
} // namespace maille::deform
