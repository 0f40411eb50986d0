#include "world/occupancy/cell_walk.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace maille::deform {
namespace {

Index3 cell_at(const std::array<CoordinatePath, 3>& paths, double angle, double t) {
  return {static_cast<int>(std::floor(paths[0].at(t, angle))),
          static_cast<int>(std::floor(paths[1].at(t, angle))),
          static_cast<int>(std::floor(paths[2].at(t, angle)))};
}

// Oracle: the path looked at at very many times; each cell seen must be the walk's at that time.
TEST(CellWalkOracle, TheCellAtAnyTimeIsTheLastOneEntered) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-6, 6);
  for (int round = 0; round < 400; ++round) {
    const double angle = round % 3 == 0 ? 0 : any(random) / 6 * std::numbers::pi;
    std::array<CoordinatePath, 3> paths;
    for (CoordinatePath& path : paths)
      path = {any(random), any(random), angle == 0 ? 0 : any(random), angle == 0 ? 0 : any(random)};
    CellWalk walk(paths, angle, cell_at(paths, angle, 0));
    const int n = 2000;
    auto step = walk.next(2);
    Index3 cell = cell_at(paths, angle, 0);
    for (int i = 0; i < n; ++i) {
      const double t = (i + 0.5) / n;
      while (step && step->time < t) {
        cell[static_cast<std::size_t>(step->axis)] += step->direction;
        ASSERT_EQ(cell, walk.cell());
        step = walk.next(1);
      }
      ASSERT_EQ(cell, cell_at(paths, angle, t)) << "round " << round << ", time " << t;
    }
  }
}

TEST(CellWalkAnalytic, AStraightPathCrossesPlanesAtTheirTimes) {
  // From (0.5, 0.25, 0.5) by (4, 2, 0): x at 1/8, 3/8, 5/8, 7/8 and y at 3/8 and 7/8; of two at once x comes
  // first.
  const std::array<CoordinatePath, 3> paths{{{0.5, 4, 0, 0}, {0.25, 2, 0, 0}, {0.5, 0, 0, 0}}};
  CellWalk walk(paths, 0, {0, 0, 0});
  const double times[] = {0.125, 0.375, 0.375, 0.625, 0.875, 0.875};
  const int axes[] = {0, 0, 1, 0, 0, 1};
  for (int i = 0; i < 6; ++i) {
    const auto step = walk.next(1);
    ASSERT_TRUE(step);
    EXPECT_DOUBLE_EQ(step->time, times[i]);
    EXPECT_EQ(step->axis, axes[i]);
  }
  EXPECT_FALSE(walk.next(1));
  EXPECT_EQ(walk.cell(), (Index3{4, 2, 0}));
}

TEST(CellWalkAnalytic, AQuarterTurnCrossesPlanesAtArcSines) {
  // (10.5 cos, 10.5 sin) about the corner of cell 0: y = k at asin(k / 10.5), x = k at acos(k / 10.5).
  const std::array<CoordinatePath, 3> paths{{{0, 0, 10.5, 0}, {0, 0, 0, 10.5}, {0.5, 0, 0, 0}}};
  const double angle = std::numbers::pi / 2;
  CellWalk walk(paths, angle, {10, 0, 0});
  int up = 0, down = 10;
  while (const auto step = walk.next(1)) {
    const double expected = step->axis == 1 ? std::asin(++up / 10.5) : std::acos(down-- / 10.5);
    EXPECT_NEAR(step->time, expected / angle, 1e-14); // rounding of the arc's numbers
    EXPECT_EQ(step->direction, step->axis == 1 ? 1 : -1);
  }
  EXPECT_EQ(up, 10);
  EXPECT_EQ(down, 0);
}

} // namespace
} // namespace maille::deform
