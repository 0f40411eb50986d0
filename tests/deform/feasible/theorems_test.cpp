/// The theorems that propagation rests on (docs/theory.md, section 1), each checked on what the product does.
///
/// 1  the clamp moves every node least              here
/// 2  closed form on voxel sets reached monotonely  here, and theorems_test.cpp
/// 3  what changes is closed toward the handle      here, and theorems_test.cpp
/// 4  many handles: which can be met, and intervals here, and limits_test.cpp, separable_scans_test.cpp
/// 5  projection                                        separable_scans_test.cpp, wavefront_test.cpp
/// 6  paths of a drag                               here, and drag_test.cpp, wavefront_drag_test.cpp

#include "feasible/bounds/bound_source.hpp"
#include "feasible/box/closed_form.hpp"
#include "feasible/limits.hpp"
#include "lattice/body.hpp"
#include "maille/deform/drag.hpp"
#include "maille/deform/plan.hpp"
#include "maille/deform/solve.hpp"
#include "maille/scene/link_limits.hpp"
#include "oracle/literal.hpp"
#include "support/bodies/lattice_scenes.hpp"
#include "support/fields.hpp"
#include "support/kit.hpp"
#include "support/vector_targets.hpp"
#include "support/worlds/all_paths.hpp"

namespace maille::deform {
namespace {

using test::AllPaths;
using test::below;
using test::random_dyadic;
using test::random_node;

/// A feasible state: handles pulled one after the other. Dyadic.
Displacement feasible_state(std::mt19937& random, const Scene& scene, const LinkLimits& limits) {
  Displacement state(scene.specimen.grid);
  for (int k = 0; k < 3; ++k) {
    Scene step = scene;
    step.prescribed.clear();
    test::move(step, random_node(random, scene.specimen.grid), random_dyadic(random, 3));
    state = drag_limits(step, limits, state).displacement;
  }
  return state;
}

Scene small_box(std::mt19937& random) {
  Scene scene = test::lattice_box({1}, test::random_dyadic_limits(random));
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
    test::move(scene, handle, random_dyadic(random, 4));
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

TEST(Theorem2Oracle, TheClosedFormIsTheShortestPath) {
  // Growing sets: a cell may join if it lies next to one that is nearer to the corner. Up to 10 x 9 x 8
  // cells.
  int n_reached = 0;
  for (unsigned seed = 1; seed <= 120; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    Scene scene = test::lattice_box({1}, test::random_dyadic_limits(random));
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
    test::move(scene, handle, by);
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
    const Scene scene = test::random_box(random, 3);
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

TEST(Theorem4Oracle, HandlesAreMetUnlessAPairExceedsItsPath) {
  int n_met = 0, n_cut = 0;
  for (unsigned seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    Scene scene = small_box(random);
    for (int k = 1 + below(random, 5); k >= 0; --k)
      test::prescribe(scene, scene.specimen.grid.node(random_node(random, scene.specimen.grid)),
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
      test::hold(scene, random_node(random, scene.specimen.grid));
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

TEST(Theorem6Oracle, MonotonePathsEndTheSameAndAWayBackLeavesAResidue) {
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
      test::move(step, scene.specimen.grid.node_at(node), place);
      expected = drag_limits(step, limits, expected).displacement;
    }
    ASSERT_EQ(at_once.displacement(), expected);
    const double largest = test::largest(expected);
    const Drag::Residue left = at_once.residue();
    EXPECT_EQ(left.largest, largest);
    EXPECT_EQ(std::abs(expected(left.component, left.node)), largest);
    n_left += largest > 0 ? 1 : 0;
  }
  EXPECT_GE(n_left, 3); // the model is plastic
}

using test::even_limits;
using test::ForcedVectors;
using test::lattice_box;
using test::random_box;
using test::vector_targets;

/// A body of float32, dragged by the closed form alone.
class DraggedBody {
public:
  DraggedBody(const Scene& scene, int threads, bool stops = true)
      : body(scene), bounds_(intervals_by_axis(scene, LinkLimits(scene))), form_(scene.specimen.grid),
        team_(threads), stops_(stops) {}

  std::int64_t drag(const Index3& handle, const Vec3& to) {
    for (int b = 0; b < body.dimension(); ++b) {
      const auto i = static_cast<std::size_t>(b);
      form_.add(b, body.field(b), bounds_[i], handle, to[i], rounding_[i], stops_);
    }
    return form_.run(team_);
  }

  Body body;

private:
  std::array<LinkIntervals<double>, 3> bounds_;
  ClosedForm<float> form_;
  ThreadTeam team_;
  std::array<Rounding, 3> rounding_;
  bool stops_;
};

TEST(ClosedFormOracle, SuccessiveDragsEqualDijkstra) {
  const auto targets = vector_targets();
  ASSERT_GE(targets.size(), 1U);
  for (unsigned seed = 1; seed <= 25; ++seed) {
    std::mt19937 random(seed);
    const Scene scene = random_box(random, 1 + test::below(random, 3));
    const LinkLimits limits(scene);
    std::vector<Index3> handles;
    std::vector<Vec3> by;
    std::vector<Displacement> expected;
    Displacement state(scene.specimen.grid);
    for (int k = 0; k < 6; ++k) {
      handles.push_back(random_node(random, scene.specimen.grid));
      by.push_back(random_dyadic(random, 8));
      Scene step = scene;
      test::move(step, handles.back(), by.back());
      state = drag_limits(step, limits, state).displacement;
      expected.push_back(state);
    }
    for (const std::int64_t target : targets) {
      const ForcedVectors forced(target);
      ASSERT_EQ(hwy::SupportedTargets(), target);
      for (const int threads : {1, 2, 3, 7}) {
        DraggedBody dragged(scene, threads);
        for (std::size_t k = 0; k < handles.size(); ++k) {
          dragged.drag(handles[k], by[k]);
          ASSERT_EQ(dragged.body.displacement(), expected[k])
              << "seed " << seed << " drag " << k << " " << hwy::TargetName(target) << " threads " << threads;
        }
      }
    }
  }
}

/// A box large enough for several threads, limits and moves that are not dyadic.
Scene rounded_box() {
  NeighbourLimits limits = even_limits(1.23456, 0.87654, 0.1357);
  limits.stretch[1] = 1.0999;
  limits.shear[2][0] = 0.0777;
  return lattice_box({41, 37, 33}, limits);
}

std::vector<Displacement> states_of_rounded_drags(int threads, bool stops) {
  const Scene scene = rounded_box();
  DraggedBody dragged(scene, threads, stops);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Displacement> states;
  for (int k = 0; k < 12; ++k) {
    const double size = k % 3 == 0 ? 9 : 0.9; // of the whole body, or of a few nodes
    dragged.drag(random_node(random, scene.specimen.grid),
                 {size * uniform(random), size * uniform(random), size * uniform(random)});
    states.push_back(dragged.body.displacement());
  }
  return states;
}

TEST(ClosedFormContract, SameBitsForVectorsAndThreads) {
  const auto expected = states_of_rounded_drags(1, true);
  for (const std::int64_t target : vector_targets()) {
    const ForcedVectors forced(target);
    for (const int threads : {1, 2, 3, 7}) {
      const auto states = states_of_rounded_drags(threads, true);
      for (std::size_t k = 0; k < states.size(); ++k)
        ASSERT_EQ(states[k], expected[k])
            << hwy::TargetName(target) << " threads " << threads << " drag " << k;
    }
  }
}

TEST(ClosedFormOracle, LeavingEarlyChangesNoBit) { // Theorem 3, and that the margin covers rounding
  const auto sparse = states_of_rounded_drags(1, true), dense = states_of_rounded_drags(1, false);
  for (std::size_t k = 0; k < dense.size(); ++k)
    ASSERT_EQ(sparse[k], dense[k]) << "drag " << k;
}

TEST(ClosedFormContract, ViolatesNoLimitBeyondRoundingAfterManyDrags) {
  const Scene scene = rounded_box();
  const LinkLimits limits(scene);
  DraggedBody dragged(scene, 1);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int k = 0; k < 300; ++k)
    dragged.drag(random_node(random, scene.specimen.grid),
                 {9 * uniform(random), uniform(random), uniform(random)});
  // A stored number is a sum of two rounded ones; a link compares two of them, displacements are below 16.
  const double ulp = 16 * std::numeric_limits<float>::epsilon() / 2;
  EXPECT_LE(largest_violation(scene, limits, dragged.body.displacement()), 4 * ulp);
}

TEST(ClosedFormContract, ALocalDragVisitsWhatItMoves) {
  Scene scene = lattice_box({99, 99, 99}, even_limits(1.25, 0.75, 0.25));
  DraggedBody dragged(scene, 1);
  const std::int64_t visited = dragged.drag({50, 50, 50}, {1.5, 1.5, 1.5});
  const Displacement state = dragged.body.displacement();
  const std::int64_t moved = std::ranges::count_if(state.values(), [](double u) { return u != 0; });
  EXPECT_EQ(moved, 3 * 231); // Analytic: |o_x| + |o_y| + |o_z| < 6, an octahedron of 231 nodes
  EXPECT_GE(visited, moved);
  EXPECT_LE(visited, 3 * 2 * 16 * 11 * 11); // two blocks of 16 in each of 11 x 11 rows
}

TEST(MonotoneReachOracle, IsWhatPathsWithoutTurningBackReach) {
  int n_true = 0, n_false = 0;
  for (unsigned seed = 1; seed <= 300; ++seed) {
    std::mt19937 random(seed);
    Scene scene = lattice_box({1}, even_limits(1.5, 0.5, 0.5));
    scene.specimen.grid = Grid(3, {4, 3, 3}, {1, 1, 1});
    scene.specimen.material_id.assign(36, 0);
    for (int k = test::below(random, 9); k >= 0; --k)
      scene.specimen.material_id[static_cast<std::size_t>(test::below(random, 36))] = no_material;
    const Grid& grid = scene.specimen.grid;
    const Index3 from = random_node(random, grid);
    if (!scene.specimen.is_node(from))
      continue;
    // Slack is even, so the shortest path has |offset| links of 0.5 each if and only if one is monotone.
    const LinkLimits limits(scene);
    const std::vector<PathEnd> end{{grid.node(from), 0.0}};
    const auto distance = shortest_paths(scene, limits, 0, end, PathDirection::from_ends);
    bool expected = true;
    for (std::int64_t n = 0; n < grid.n_nodes(); ++n) {
      const Index3 at = grid.node_at(n);
      if (!scene.specimen.is_node(at))
        continue;
      const int links = std::abs(at[0] - from[0]) + std::abs(at[1] - from[1]) + std::abs(at[2] - from[2]);
      expected = expected && distance[static_cast<std::size_t>(n)] == 0.5 * links;
    }
    (expected ? n_true : n_false)++;
    EXPECT_EQ(reaches_all_monotonely(scene.specimen, from), expected) << "seed " << seed;
  }
  EXPECT_GE(n_true, 30);
  EXPECT_GE(n_false, 30);
}

} // namespace
} // namespace maille::deform
