#include "export/body_numbering.hpp"

#include "studies/export/export_scenes.hpp"

#include <gtest/gtest.h>

#include <random>

namespace maille::studies {
namespace {

double dot(const Vec3& a, const Vec3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// A sheet whose fibres rotate by 2 degrees from cell to cell, with random signs.
Scene fan(unsigned seed) {
  Scene scene = test::block(2, {60, 3, 1});
  std::mt19937 lot(seed);
  for (std::int64_t cell = 0; cell < scene.specimen.grid.n_cells(); ++cell) {
    const double angle = 0.035 * scene.specimen.grid.cell_at(cell)[0], sign = lot() % 2 == 0 ? 1 : -1;
    scene.specimen.fibres.push_back(
        {static_cast<float>(sign * std::cos(angle)), static_cast<float>(sign * std::sin(angle)), 0});
  }
  return scene;
}

// Truth: the field without the lot: it turns smoothly by 118 degrees, and its sum points along +y.
TEST(FibreSignsAnalytic, NeighboursAgreeAndTheWholePointsAhead) {
  const std::vector<Vec3> one = with_one_sign(fan(1).specimen, {}), two = with_one_sign(fan(2).specimen, {});
  const Grid& grid = fan(1).specimen.grid;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    const auto c = static_cast<std::size_t>(cell);
    const double angle = 0.035 * grid.cell_at(cell)[0];
    EXPECT_NEAR(one[c][0], std::cos(angle), 1e-6);
    EXPECT_NEAR(one[c][1], std::sin(angle), 1e-6);
    EXPECT_EQ(one[c], two[c]);
  }
}

// Truth: parts that do not touch each point along the world's axis that they are most nearly parallel to.
TEST(FibreSignsAnalytic, EveryPartPointsAlongThePositiveWorld) {
  Scene scene = test::block(1, {3, 1, 1});
  scene.specimen.material_id = {0, no_material, 0};
  scene.specimen.fibres = {{-0.8f, 0.6f, 0}, {0, 0, 0}, {0.28f, 0.96f, 0}};
  EXPECT_GT(dot(with_one_sign(scene.specimen, {})[0], {0.8, -0.6, 0}), 0.99);
  // A quarter turn about z: the object's y runs along the world's -x.
  const Placement turned{{}, {{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}}};
  EXPECT_GT(dot(with_one_sign(scene.specimen, turned)[0], {0.8, -0.6, 0}), 0.99);
  EXPECT_GT(dot(with_one_sign(scene.specimen, turned)[2], {-0.28, -0.96, 0}), 0.99);
  EXPECT_EQ(with_one_sign(scene.specimen, {})[1], (Vec3{0, 0, 0}));
}

} // namespace
} // namespace maille::studies
