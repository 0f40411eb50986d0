#include "maille/scene/block_frames.hpp"

#include "maille/materials/fault.hpp"
#include "maille/scene/cell_fields.hpp"
#include "maille/scene/read_scene.hpp"
#include "support/bodies/bent_bar.hpp"

#include <gtest/gtest.h>

namespace maille {
namespace {

using std::numbers::pi;

/// Every node on its place on the arc.
Displacement arc(const Scene& scene, double angle) {
  Displacement u(scene.specimen.grid);
  for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node) {
    const Vec3 x = scene.specimen.position(scene.specimen.grid.node_at(node)), there = test::on_arc(x, angle);
    for (int b = 0; b < scene.dimension(); ++b)
      u(b, node) = there[static_cast<std::size_t>(b)] - x[static_cast<std::size_t>(b)];
  }
  return u;
}

// Truth: an arc turns by the angle times the part of the way along it; its strain is the height over the
// radius.
TEST(BlockFramesAnalytic, AnArcTurnsLittleByLittle) {
  for (const int dimension : {2, 3})
    for (const double angle : {0.5, pi / 2, 3.1}) {
      const Scene scene = test::straight_bar(dimension, 4);
      const Displacement u = arc(scene, angle);
      const auto rotation = block_rotations(scene, u);
      const CellFields fields = cell_fields(scene, u);
      for (std::int64_t cell = 0; cell < scene.specimen.grid.n_cells(); ++cell) {
        const Index3 at = scene.specimen.grid.cell_at(cell);
        const Eigen::AngleAxisd turn(rotation[static_cast<std::size_t>(cell)]);
        EXPECT_NEAR(turn.angle() * turn.axis()[2], angle * (at[0] + 0.5) / 16, 1e-12);
        // The mean gradient of a cell is that of its chord, shorter by the sine of half a cell's turn over
        // that turn.
        const double half = angle / 32, curved = std::sin(half) / half;
        const double strain = curved * (1 - angle / 4 * (at[1] - 1.5) / 4) - 1;
        EXPECT_NEAR(fields.strain[static_cast<std::size_t>(cell)][0], strain, 1e-12);
        EXPECT_NEAR(fields.strain[static_cast<std::size_t>(cell)][3], 0, 1e-12);
      }
    }
}

// Truth: the surface's links are longer by height over radius, within a cell's turn.
TEST(BlockFramesAnalytic, LinksOnAnArcAreMeasuredWhereTheyAre) {
  Scene scene = test::straight_bar(3, 8);
  scene.limits.from = LimitSource::given;
  scene.limits.given.stretch.fill(1.05);
  scene.limits.given.compress.fill(0.5);
  for (auto& row : scene.limits.given.shear)
    row.fill(0.05);
  const double angle = pi / 2, surface = angle * test::bar_height / 2 / test::bar_length;
  const double half = angle / 64, chord = std::sin(half) / half; // of an arc of one cell
  EXPECT_NEAR(largest_violation_in_blocks(scene, LinkLimits(scene), arc(scene, angle)),
              (1 + surface) * chord - 1.05, 1e-12);
  scene.limits.given.stretch.fill(1.2);
  EXPECT_EQ(largest_violation_in_blocks(scene, LinkLimits(scene), arc(scene, angle)), 0);
}

TEST(BlockFramesContract, ASceneAsksForThem) {
  const std::string head = R"(
[specimen]
shape = "box"
cells = [4, 2]
spacing = "1 m"
material = "fat/subcutaneous"
[[hold]]
where = "x-"
[relaxation]
)";
  const Scene scene = parse_scene(head + "frame = \"blocks\"\nincrements = 7", "blocks.toml");
  EXPECT_TRUE(in_blocks(scene));
  EXPECT_EQ(scene.relaxation.increments, 7);
  EXPECT_FALSE(in_blocks(parse_scene(head + "frame = \"object\"", "object.toml")));
  EXPECT_FALSE(in_blocks(parse_scene(head, "neither.toml")));
  EXPECT_THROW(parse_scene(head + "frame = \"world\"", "world.toml"), InputError);
  EXPECT_THROW(parse_scene(head + "increments = 0", "none.toml"), InputError);
}

} // namespace
} // namespace maille
