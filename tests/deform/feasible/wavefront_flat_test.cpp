/// The wavefront on bodies that are one node or one cell thick along some axis.

#include "feasible/forecast.hpp"
#include "feasible/wavefront/wavefront.hpp"

#include "support/bodies/holed_bodies.hpp"
#include "support/quanta.hpp"

#include <gtest/gtest.h>

namespace maille::deform {
namespace {

using tests::Dice;

/// Three materials of random limits, in cells of a grid of that size; holes in a third of the bodies.
Scene flat_body(std::mt19937& random, int dimension, const Index3& cells) {
  Dice dice{random};
  Scene scene = tests::lattice_box({1}, {});
  scene.specimen.grid = Grid(dimension, cells, {1, 0.5, 0.75});
  scene.limits.from = LimitSource::material;
  scene.materials.assign(3, scene.materials[0]);
  for (Material& material : scene.materials)
    material.limits = tests::uneven_limits(dice);
  auto& kinds = scene.specimen.material_id;
  kinds.resize(static_cast<std::size_t>(scene.specimen.grid.n_cells()));
  const int holes = dice.below(3) == 0 ? 20 : 0; // percent
  for (auto& kind : kinds)
    kind = dice.below(100) < holes ? no_material : static_cast<std::uint8_t>(dice.below(3));
  kinds[0] = 0;
  tests::prescribe_at_random(scene, dice);
  return scene;
}

void expect_dijkstra(Scene scene, std::mt19937& random) {
  Dice dice{random};
  const LinkLimits limits(scene);
  TiledBody body(scene, limits);
  tests::StateByDijkstra expected(scene, limits, body);
  for (int drag = 0; drag < 3; ++drag) {
    const std::vector<Prescribed> clipped = body.move(scene.prescribed);
    expected.move(body, clipped);
    Displacement u(scene.specimen.grid);
    body.copy_to(u);
    ASSERT_EQ(u, expected.displacement(clipped)) << "drag " << drag;
    tests::prescribe_at_random(scene, dice);
  }
}

TEST(WavefrontFlatOracle, EqualsDijkstraToTheBitHoweverThinTheBodyIs) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    std::mt19937 random(seed);
    Dice dice{random};
    const int n = 1 + dice.below(40), m = 1 + dice.below(20), thin = 1 + dice.below(8);
    const std::vector<std::pair<int, Index3>> shapes{
        {1, {n, 1, 1}},    {2, {n, m, 1}},    {2, {1, n, 1}},    {2, {n, 1, 1}}, // 1D and 2D
        {3, {n, m, 1}},    {3, {n, 1, m}},    {3, {1, n, m}},                    // sheets of one cell
        {3, {n, 1, 1}},    {3, {1, n, 1}},    {3, {1, 1, n}},    {3, {1, 1, 1}}, // strands of one cell
        {3, {n, m, thin}}, {3, {n, thin, m}}, {3, {thin, n, m}},
    };
    for (const auto& [dimension, cells] : shapes) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << " " << dimension << "D, " << cells[0] << " x "
                                      << cells[1] << " x " << cells[2] << " cells");
      expect_dijkstra(flat_body(random, dimension, cells), random);
      ASSERT_FALSE(HasFailure());
    }
  }
}

TEST(WavefrontFlatContract, ABodyThatIsThinAlongZHoldsNoMoreLayersThanItNeeds) {
  const auto bytes_of_values = [](int thickness) {
    const Scene scene = tests::lattice_box({63, 63, thickness}, tests::even_limits(1.25, 0.75, 0.25));
    for (const ArrayBytes& array : forecast_of_tiles(scene, LinkLimits(scene)))
      if (array.name == "displacement")
        return array.bytes;
    return std::int64_t{-1};
  };
  // 64 x 64 nodes and 3 components of 4 bytes, times the layers: a power of two.
  const std::int64_t layer = 64 * 64 * 3 * 4;
  EXPECT_EQ(bytes_of_values(1), 2 * layer);
  EXPECT_EQ(bytes_of_values(3), 4 * layer);
  EXPECT_EQ(bytes_of_values(4), 8 * layer);
  EXPECT_EQ(bytes_of_values(8), 16 * layer);
}

} // namespace
} // namespace maille::deform
