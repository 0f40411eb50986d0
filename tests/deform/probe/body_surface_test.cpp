#include "maille/deform/probe/touch.hpp"

#include "deform/probe/probe_scenes.hpp"
#include "support/dice.hpp"

#include <gtest/gtest.h>

namespace maille::deform {
namespace {

using tests::Dice;

// Oracle: every triangle asked.
TEST(BodySurfaceOracle, TheFirstHitIsThatOfEveryTriangle) {
  const Scene scene = test::carved_body({7, 6, 8}, {1e-3, 1.2e-3, 0.9e-3});
  const BodySurface surface(scene, test::bent(scene, 0.7),
                            test::turned_pose(0.4, {1, 2, 3}, {0.02, 0.01, 0.03}));
  std::mt19937 random(4);
  Dice dice{random};
  int hits = 0;
  for (int path = 0; path < 8000; ++path) {
    const Eigen::Vector3d middle =
        surface.pose().position + surface.pose().rotation * Eigen::Vector3d(3.5e-3, 3.5e-3, 3.5e-3);
    const Eigen::Vector3d from = middle + dice.between(0, 0.012) * dice.direction();
    const Eigen::Vector3d to = from + std::pow(10, dice.between(-4, -1)) * dice.direction();
    const auto fast = surface.first_hit(from, to), every = surface.first_hit_of_every_triangle(from, to);
    ASSERT_EQ(fast.has_value(), every.has_value()) << "path " << path;
    if (!fast)
      continue;
    ++hits;
    ASSERT_EQ(fast->time, every->time);
    ASSERT_EQ(fast->face, every->face);
  }
  EXPECT_GT(hits, 500);
}

// Oracle: which cells hold matter.
TEST(BodySurfaceOracle, AtRestInsideIsWhereMatterIs) {
  const Scene scene = test::carved_body({6, 5, 7}, {1, 1, 1});
  const BodySurface surface(scene, {}, {});
  std::mt19937 random(5);
  Dice dice{random};
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d at(dice.between(-1, 7), dice.between(-1, 6), dice.between(-1, 8));
    const Index3 cell{static_cast<int>(std::floor(at[0])), static_cast<int>(std::floor(at[1])),
                      static_cast<int>(std::floor(at[2]))};
    const Grid& grid = scene.specimen.grid;
    ASSERT_EQ(surface.is_inside(at), grid.has_cell(cell) && scene.specimen.is_matter(grid.cell(cell)));
  }
}

// Oracle: the solid angle of every triangle.
TEST(BodySurfaceOracle, InsideIsWhatTheSolidAngleSays) {
  const Scene scene = test::carved_body({6, 5, 7}, {1, 1.2, 0.9});
  const BodySurface surface(scene, test::bent(scene, 0.6), test::turned_pose(0.4, {1, 2, 3}, {1, 2, 3}));
  Eigen::AlignedBox3d box;
  for (const BodySurface::Face& face : surface.faces())
    for (const std::int32_t corner : face.corners)
      box.extend(surface.position(corner));
  std::mt19937 random(9);
  Dice dice{random};
  int n_inside = 0;
  for (int i = 0; i < 5000; ++i) {
    const Eigen::Vector3d unit(dice.between(0, 1), dice.between(0, 1), dice.between(0, 1));
    const Eigen::Vector3d at = box.min() + box.sizes().cwiseProduct(unit);
    const bool expected = surface.is_inside_of_every_triangle(at);
    n_inside += expected;
    ASSERT_EQ(surface.is_inside(at), expected) << "point " << i;
  }
  EXPECT_GT(n_inside, 1000);
}

TEST(BodySurfaceAnalytic, APathComesInThroughTheFaceInItsWay) {
  const Scene scene = test::box_scene(3, {4, 4, 4}, {1, 1, 1});
  Displacement stretched(scene.specimen.grid);
  for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node)
    stretched(2, node) = 0.25 * scene.specimen.grid.node_at(node)[2];
  const BodySurface surface(scene, stretched, {});
  EXPECT_EQ(surface.faces().size(), 6u * 16u);
  // Analytic: the upper face is at 4 * 1.25 = 5.
  const auto hit = surface.first_hit({1.3, 2.6, 9}, {1.3, 2.6, 1});
  ASSERT_TRUE(hit);
  EXPECT_DOUBLE_EQ(hit->time, 0.5);
  EXPECT_LT((hit->normal - Eigen::Vector3d::UnitZ()).norm(), 1e-15);
  const auto& face = surface.faces()[static_cast<std::size_t>(hit->face)];
  EXPECT_EQ(face.axis, 2);
  EXPECT_TRUE(face.upper);
  EXPECT_EQ(scene.specimen.grid.cell_at(face.cell), (Index3{1, 2, 3}));
  EXPECT_FALSE(surface.first_hit({1.3, 2.6, 2}, {1.3, 2.6, 9})); // out is free
  // Paths through edges and corners of triangles come in too.
  for (const double x : {0.0, 1.0, 2.5, 4.0})
    for (const double y : {0.0, 2.0, 2.5, 4.0})
      EXPECT_TRUE(surface.first_hit({x, y, 9}, {x, y, 1})) << x << ' ' << y;
}

TEST(BodySurfaceContract, OnlyBodiesOfThreeDimensionsHaveOne) {
  EXPECT_THROW(BodySurface(test::box_scene(2, {4, 4, 1}), {}, {}), std::invalid_argument);
}

} // namespace
} // namespace maille::deform
