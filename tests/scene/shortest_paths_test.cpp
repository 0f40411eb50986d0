#include "maille/scene/link_limits.hpp"

#include "support/bodies/scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace maille {
namespace {

Scene asymmetric_box() {
  Scene scene = test::box_scene(2, {4, 3, 1}, {1, 1, 1});
  scene.limits.from = LimitSource::given;
  scene.limits.given.stretch = {1.5, 1.25, 1};
  scene.limits.given.compress = {0.75, 0.5, 1};
  scene.limits.given.shear = {{{0, 0.125, 0}, {0.0625, 0, 0}, {}}};
  return scene;
}

TEST(ShortestPathsAnalytic, AddUpTheLimitsOfEachAxis) {
  const Scene scene = asymmetric_box();
  const Grid& grid = scene.specimen.grid;
  const LinkLimits limits(scene);
  const PathEnd end{grid.node({1, 1, 0}), 10};
  const auto from = shortest_paths(scene, limits, 0, std::span(&end, 1), PathDirection::from_ends);
  const auto to = shortest_paths(scene, limits, 0, std::span(&end, 1), PathDirection::to_ends);
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    const Index3 at = grid.node_at(node);
    const int x = at[0] - 1, y = at[1] - 1;
    // Theory, theorem 2: forward along x costs the stretch, back the compression; y costs the shear. Dyadic,
    // so exact.
    const double shear = 0.0625 * std::abs(y);
    EXPECT_EQ(from[static_cast<std::size_t>(node)], 10 + (x >= 0 ? x * 0.5 : -x * 0.25) + shear);
    EXPECT_EQ(to[static_cast<std::size_t>(node)], 10 + (x >= 0 ? x * 0.25 : -x * 0.5) + shear);
  }
}

TEST(ShortestPathsAnalytic, GoAroundASlotAndNotToAnotherPiece) {
  Scene scene = asymmetric_box();
  // Matter: a U of cells; the two arms are one row apart, and the last column is a piece that touches
  // nothing.
  scene.specimen.grid = Grid(2, {5, 3, 1}, {1, 1, 1});
  constexpr auto o = no_material;
  scene.specimen.material_id = {0, 0, 0, o, 0, //
                                0, o, o, o, o, //
                                0, 0, 0, o, o};
  const Grid& grid = scene.specimen.grid;
  const LinkLimits limits(scene);
  const PathEnd end{grid.node({3, 1, 0}), 0}; // inner corner of the lower arm's tip
  const auto length = shortest_paths(scene, limits, 0, std::span(&end, 1), PathDirection::from_ends);
  // By hand: back two cells (0.25 each), up one link (0.0625), forward two (0.5 each).
  EXPECT_EQ(length[static_cast<std::size_t>(grid.node({3, 2, 0}))], 2 * 0.25 + 0.0625 + 2 * 0.5);
  EXPECT_TRUE(std::isinf(length[static_cast<std::size_t>(grid.node({5, 0, 0}))]));
}

} // namespace
} // namespace maille
