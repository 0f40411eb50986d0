/// The rule of Gibson 1995 for the transfer of momentum.

#include "world/voxels/hand_on.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

namespace maille::deform {
namespace {

OccupancyMap map_of(const Index3& cells, const std::vector<FreeVoxel>& voxels) {
  OccupancyMap map(cells);
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    const Eigen::Vector3d& x = voxels[i].place;
    map.put({static_cast<int>(x[0]), static_cast<int>(x[1]), static_cast<int>(x[2])},
            static_cast<VoxelId>(i));
  }
  return map;
}

std::vector<FreeVoxel> row_of(int n, double first) {
  std::vector<FreeVoxel> voxels;
  for (int i = 0; i < n; ++i)
    voxels.push_back({{first + i, 0.5, 0.5}, false});
  return voxels;
}

double sum_of_moves(const Transfer& transfer, Eigen::Index axis) {
  double sum = 0;
  for (const VoxelMove& move : transfer.moves)
    sum += move.moved[axis];
  return sum;
}

// Analytic: every voxel of a row has half a cell before it; the movement is used up by as many as it takes.
TEST(HandOnAnalytic, ARowTakesTheMovementInTurn) {
  std::vector<FreeVoxel> voxels = row_of(6, 1.5);
  OccupancyMap map = map_of({20, 1, 1}, voxels);
  const Transfer transfer = hand_on(map, voxels, 0, {1.8, 0, 0});
  const double expected[] = {0.5, 0.5, 0.5, 0.3};
  ASSERT_EQ(transfer.moves.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(transfer.moves[i].voxel, static_cast<VoxelId>(i));
    EXPECT_NEAR(transfer.moves[i].moved[0], expected[i], 1e-8); // stops a billionth of a cell before a face
    EXPECT_NEAR(voxels[i].place[0], 1.5 + double(i) + expected[i], 1e-8);
  }
  EXPECT_EQ(voxels[4].place[0], 5.5);
  EXPECT_TRUE(transfer.refused.isZero(0));
  // The last of the row has room: it takes whatever is left, over several cells.
  const Transfer far = hand_on(map, voxels, 5, {7.25, 0, 0});
  ASSERT_EQ(far.moves.size(), 1u);
  EXPECT_EQ(voxels[5].place[0], 13.75);
}

// Analytic: "until either the sum of the voxel movements is equal to the desired movement or a fixed voxel is
// encountered".
TEST(HandOnAnalytic, AFixedVoxelAndTheBorderEndTheTransfer) {
  for (const bool at_border : {false, true}) {
    std::vector<FreeVoxel> voxels = row_of(4, 0.5);
    voxels[3].is_fixed = !at_border;
    OccupancyMap map = map_of({4, 1, 1}, voxels);
    const Transfer transfer = hand_on(map, voxels, 0, {3, 0, 0});
    const double moved = at_border ? 2 : 1.5; // half a cell each, of four voxels or of three
    EXPECT_EQ(transfer.moves.size(), at_border ? 4u : 3u);
    EXPECT_NEAR(sum_of_moves(transfer, 0), moved, 1e-8);
    EXPECT_NEAR(transfer.refused[0], 3 - moved, 1e-8);
    EXPECT_EQ(transfer.refused_by, at_border ? no_voxel : 3);
  }
}

// Oracle: every cell looked for among all voxels. And whatever happens, all that was asked is moved or
// refused, and no cell has two voxels.
TEST(HandOnOracle, TheMapFindsWhomASearchAmongAllVoxelsFinds) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(0, 1);
  std::size_t longest = 0;
  int refused = 0;
  for (int round = 0; round < 60; ++round) {
    const int dimension = 1 + round % 3;
    const Index3 cells{dimension == 1 ? 60 : 9, dimension > 1 ? 9 : 1, dimension > 2 ? 5 : 1};
    std::vector<FreeVoxel> fast;
    for (int z = 0; z < cells[2]; ++z)
      for (int y = 0; y < cells[1]; ++y)
        for (int x = 0; x < cells[0]; ++x)
          if (unit(random) < 0.6) {
            FreeVoxel voxel{{x + unit(random), 0.5, 0.5}, unit(random) < 0.05};
            if (dimension > 1)
              voxel.place[1] = y + unit(random);
            if (dimension > 2)
              voxel.place[2] = z + unit(random);
            fast.push_back(voxel);
          }
    std::vector<FreeVoxel> literal = fast;
    OccupancyMap map = map_of(cells, fast);
    for (int push = 0; push < 50; ++push) {
      Eigen::Vector3d movement = Eigen::Vector3d::Zero();
      for (int a = 0; a < dimension; ++a)
        movement[a] = 8 * (unit(random) - 0.5) * unit(random);
      if (push % 7 == 0)
        movement[0] = std::round(movement[0]); // also ways that end on faces
      const auto voxel = static_cast<VoxelId>(random() % fast.size());
      const Transfer a = hand_on(map, fast, voxel, movement),
                     b = hand_on_literally(cells, literal, voxel, movement);
      ASSERT_EQ(a.moves.size(), b.moves.size()) << "round " << round << ", push " << push;
      ASSERT_EQ(a.refused_by, b.refused_by);
      Eigen::Vector3d sum = a.refused;
      for (std::size_t i = 0; i < a.moves.size(); ++i) {
        ASSERT_EQ(a.moves[i].voxel, b.moves[i].voxel);
        sum += a.moves[i].moved;
      }
      ASSERT_LT((sum - movement).norm(), 1e-14 * (1 + static_cast<double>(a.moves.size())));
      std::set<Index3> taken;
      for (std::size_t i = 0; i < fast.size(); ++i) {
        ASSERT_EQ(fast[i].place, literal[i].place) << "round " << round << ", push " << push;
        const Eigen::Vector3d& x = fast[i].place;
        const Index3 cell{static_cast<int>(std::floor(x[0])), static_cast<int>(std::floor(x[1])),
                          static_cast<int>(std::floor(x[2]))};
        ASSERT_TRUE(taken.insert(cell).second) << "two voxels in one cell";
        ASSERT_EQ(map.occupant(cell), static_cast<VoxelId>(i));
      }
      longest = std::max(longest, a.moves.size());
      refused += a.refused.isZero(0) ? 0 : 1;
    }
  }
  EXPECT_GT(longest, 8u); // else nothing was tested
  EXPECT_GT(refused, 100);
}

} // namespace
} // namespace maille::deform
