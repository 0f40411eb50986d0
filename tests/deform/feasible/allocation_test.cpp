/// What moves allocate after their first use: nothing. And the largest body that shall fit.

#include "maille/deform/drag.hpp"
#include "maille/scene/memory.hpp"
#include "support/bodies/named_bodies.hpp"
#include "support/bodies/lattice_scenes.hpp"
#include "support/heap_meter.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace maille::deform {
namespace {

using tests::even_limits;
using tests::heap_is_counted;
using tests::HeapMeter;
using tests::hold;
using tests::lattice_box;

#define SKIP_UNLESS_COUNTED                                                                                  \
  if (!heap_is_counted())                                                                                    \
  GTEST_SKIP() << "allocations cannot be counted here"

struct Body {
  std::string name;
  Scene scene;
};

/// Homogeneous and tiled, large enough for two threads; something is held.
std::vector<Body> bodies() {
  std::vector<Body> all{{"box", lattice_box({40, 40, 40}, even_limits(1.25, 0.75, 0.25))},
                        {"sheet", lattice_box({300, 200}, even_limits(1.25, 0.75, 0.25))}};
  for (const std::string_view name : named_bodies())
    all.push_back({std::string(name), named_body(name, 40)});
  for (Body& body : all) {
    body.scene.prescribed.clear();
    hold(body.scene, {0, 0, 0});
  }
  return all;
}

/// There, back, and beyond what the hold permits.
const std::array<Vec3, 4> places{{{1, -0.5, 0.75}, {6, 2, -3}, {0, 0, 0}, {1000, -1000, 1000}}};

TEST(AllocationContract, OneHandleAllocatesNothingAfterItsFirstUse) {
  SKIP_UNLESS_COUNTED;
  for (const Body& body : bodies())
    for (const int threads : {1, 2}) {
      SCOPED_TRACE(body.name + " threads " + std::to_string(threads));
      const LinkLimits limits(body.scene);
      Drag drag(body.scene, limits, threads);
      const std::int64_t node = body.scene.specimen.grid.n_nodes() - 1;
      for (int round = 0; round < 3; ++round) {
        const HeapMeter heap;
        for (const Vec3& place : places)
          drag.move_to(node, place);
        if (round > 0) {
          EXPECT_EQ(heap.allocations(), 0) << "round " << round;
        } else {
          EXPECT_GE(heap.allocations(), 1) << "a new handle is stored, and that is seen";
        }
      }
    }
}

TEST(AllocationContract, SeveralHandlesAllocateNothingAfterTheirFirstUse) {
  SKIP_UNLESS_COUNTED;
  for (const Body& body : bodies())
    for (const int n_handles : {3, 40})
      for (const int threads : {1, 2}) {
        SCOPED_TRACE(body.name + " threads " + std::to_string(threads) + " handles " +
                     std::to_string(n_handles));
        const LinkLimits limits(body.scene);
        Drag drag(body.scene, limits, threads);
        const Grid& grid = body.scene.specimen.grid;
        std::vector<Drag::Move> moves;
        for (int k = 0; k < n_handles; ++k)
          moves.push_back({grid.node({grid.nodes()[0] - 1, k, 0}), {}});
        std::vector<Vec3> clipped(moves.size());
        for (int round = 0; round < 3; ++round) {
          const HeapMeter heap;
          for (const Vec3& place : places) {
            for (std::size_t k = 0; k < moves.size(); ++k) // the last of them contradict each other
              moves[k].displacement = {place[0] + static_cast<double>(k % 3) * place[0] / 8, place[1],
                                       place[2]};
            drag.move_to(moves, clipped);
          }
          if (round > 0) {
            EXPECT_EQ(heap.allocations(), 0) << "round " << round;
          }
        }
      }
}

TEST(AllocationContract, AHandleOfAHomogeneousBodyNeedsOneMoveOnly) {
  SKIP_UNLESS_COUNTED;
  const Scene scene = bodies().front().scene;
  const LinkLimits limits(scene);
  for (const int threads : {1, 2}) {
    Drag drag(scene, limits, threads);
    drag.move_to(77, {0.1, 0, 0});
    const HeapMeter heap;
    for (const Vec3& place : places) // it has been to none of them
      drag.move_to(77, place);
    EXPECT_EQ(heap.allocations(), 0);
  }
}

TEST(AllocationContract, ABodyOf512CubedNodesIsDraggedWithin2GiB) {
  SKIP_UNLESS_COUNTED;
  constexpr std::int64_t gib = std::int64_t{1} << 30;
  if (const std::int64_t available = available_memory(); available < 3 * gib)
    GTEST_SKIP() << "needs 3 GiB of free memory, there are "
                 << bytes_in_words(static_cast<double>(available));
  Scene scene = lattice_box({511, 511, 511}, even_limits(1.25, 0.75, 0.25));
  hold(scene, {0, 0, 0});
  const LinkLimits limits(scene);
  const Grid& grid = scene.specimen.grid;
  const HeapMeter heap;
  Drag drag(scene, limits, 2);
  const Vec3 to{383, -383, 127}; // dyadic; the farthest corner is reached: its slack is 3 * 511 / 4 = 383.25
  EXPECT_FALSE(drag.move_to(grid.node({511, 511, 511}), to).is_cut);
  EXPECT_LE(heap.peak(), 2 * gib);
  EXPECT_LE(drag.bytes(), 2 * gib);
  EXPECT_GE(heap.peak(), 12 * grid.n_nodes()); // it was counted
  std::printf("512^3 nodes: %s at the peak, %.3f bytes a node\n",
              bytes_in_words(static_cast<double>(heap.peak())).c_str(),
              static_cast<double>(heap.peak()) / static_cast<double>(grid.n_nodes()));
  // Theorem 2: a cone of slope 1/4 along every axis, to the bit.
  for (const Index3& at :
       {Index3{511, 511, 511}, {511, 0, 511}, {300, 200, 100}, {0, 0, 1}, {510, 509, 507}, {256, 256, 256}})
    for (int b = 0; b < 3; ++b) {
      const double by = to[static_cast<std::size_t>(b)], drop = 0.25 * (3 * 511 - at[0] - at[1] - at[2]);
      EXPECT_EQ(drag.displacement(b, grid.node(at)), std::copysign(std::max(0.0, std::abs(by) - drop), by));
    }
}

} // namespace
} // namespace maille::deform
