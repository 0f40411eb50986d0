#include "feasible/box/closed_form.hpp"

#include "feasible/limits.hpp"
#include "lattice/body.hpp"
#include "maille/deform/plan.hpp"
#include "maille/scene/link_limits.hpp"
#include "oracle/literal.hpp"
#include "support/bodies/lattice_scenes.hpp"
#include "support/vector_targets.hpp"

#include <gtest/gtest.h>

namespace maille::deform {
namespace {

using tests::even_limits;
using tests::ForcedVectors;
using tests::lattice_box;
using tests::random_box;
using tests::random_dyadic;
using tests::random_node;
using tests::vector_targets;

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

TEST(ClosedFormOracle, EqualsLiteralToTheBit) {
  for (int dimension = 1; dimension <= 3; ++dimension)
    for (unsigned seed = 1; seed <= 60; ++seed) {
      std::mt19937 random(seed);
      Scene scene = random_box(random, dimension);
      const Index3 handle = random_node(random, scene.specimen.grid);
      const Vec3 by = random_dyadic(random, 8);
      tests::move(scene, handle, by);
      DraggedBody dragged(scene, 1);
      dragged.drag(handle, by);
      ASSERT_EQ(dragged.body.displacement(), solve_literal(scene).displacement)
          << dimension << "D, seed " << seed;
    }
}

TEST(ClosedFormOracle, SuccessiveDragsEqualDijkstraToTheBitForEveryVectorAndThreadCount) {
  const auto targets = vector_targets();
  ASSERT_GE(targets.size(), 1U);
  for (unsigned seed = 1; seed <= 25; ++seed) {
    std::mt19937 random(seed);
    const Scene scene = random_box(random, 1 + tests::below(random, 3));
    const LinkLimits limits(scene);
    std::vector<Index3> handles;
    std::vector<Vec3> by;
    std::vector<Displacement> expected;
    Displacement state(scene.specimen.grid);
    for (int k = 0; k < 6; ++k) {
      handles.push_back(random_node(random, scene.specimen.grid));
      by.push_back(random_dyadic(random, 8));
      Scene step = scene;
      tests::move(step, handles.back(), by.back());
      state = drag_limits(step, limits, state).displacement;
      expected.push_back(state);
    }
    for (const std::int64_t target : targets) {
      const ForcedVectors forced(target);
      ASSERT_STREQ(kind_of_vectors(), hwy::TargetName(target));
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

TEST(ClosedFormContract, SameBitsForEveryVectorAndThreadCountThoughSumsAreRounded) {
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

TEST(ClosedFormOracle, HoldsInMaskedBodiesThatTheHandleReachesMonotonely) {
  int n_reached = 0;
  for (unsigned seed = 1; seed <= 400; ++seed) {
    std::mt19937 random(seed);
    Scene scene = lattice_box({1}, tests::random_dyadic_limits(random));
    scene.specimen.grid = Grid(3, {3, 3, 2}, {1, 1, 1});
    scene.specimen.material_id.assign(18, 0);
    for (int k = tests::below(random, 6); k >= 0; --k)
      scene.specimen.material_id[static_cast<std::size_t>(tests::below(random, 18))] = no_material;
    Index3 handle = random_node(random, scene.specimen.grid);
    const Vec3 by = random_dyadic(random, 4);
    if (!scene.specimen.is_node(handle) || !reaches_all_monotonely(scene.specimen, handle))
      continue;
    ++n_reached;
    DraggedBody dragged(scene, 1);
    dragged.drag(handle, by);
    tests::move(scene, handle, by);
    ASSERT_EQ(dragged.body.displacement(), solve_limits(scene).displacement) << "seed " << seed;
  }
  EXPECT_GE(n_reached, 50);
}

TEST(MonotoneReachOracle, IsWhatPathsWithoutTurningBackReach) {
  int n_true = 0, n_false = 0;
  for (unsigned seed = 1; seed <= 300; ++seed) {
    std::mt19937 random(seed);
    Scene scene = lattice_box({1}, even_limits(1.5, 0.5, 0.5));
    scene.specimen.grid = Grid(3, {4, 3, 3}, {1, 1, 1});
    scene.specimen.material_id.assign(36, 0);
    for (int k = tests::below(random, 9); k >= 0; --k)
      scene.specimen.material_id[static_cast<std::size_t>(tests::below(random, 36))] = no_material;
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
