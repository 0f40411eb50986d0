#include "maille/deform/world/occupancy_map.hpp"

#include "support/vector_targets.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>

namespace maille::deform {
namespace {

// Oracle: a dictionary of cells.
TEST(OccupancyMapOracle, RowsPutAndTakenAreThoseOfADictionary) {
  const Index3 cells{70, 21, 35};
  OccupancyMap map(cells);
  std::map<Index3, VoxelId> truth;
  std::mt19937 random(7);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  VoxelId next = 0;
  for (int round = 0; round < 4000; ++round) {
    Index3 at{below(cells[0]), below(cells[1]), below(cells[2])};
    const int n = 1 + below(cells[0] - at[0]);
    const bool puts = below(2) == 0;
    puts ? map.put_row(at, n, next) : map.take_row(at, n);
    for (int i = 0; i < n; ++i, ++at[0])
      if (puts)
        truth.try_emplace(at, next + i);
      else
        truth.erase(at);
    next += n;
  }
  ASSERT_EQ(map.n_occupied(), static_cast<std::int64_t>(truth.size()));
  for (int z = 0; z < cells[2]; ++z)
    for (int y = 0; y < cells[1]; ++y)
      for (int x = 0; x < cells[0]; ++x) {
        const auto found = truth.find({x, y, z});
        ASSERT_EQ(map.occupant({x, y, z}), found == truth.end() ? no_voxel : found->second);
      }
}

TEST(OccupancyMapOracle, BoxesAreSearchedToTheCell) {
  const Index3 cells{40, 40, 40};
  OccupancyMap map(cells);
  std::mt19937 random(11);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  for (int i = 0; i < 40; ++i)
    map.put({below(40), below(40), below(40)}, i);
  for (int round = 0; round < 2000; ++round) {
    Index3 first, last;
    for (std::size_t a = 0; a < 3; ++a) {
      first[a] = below(50) - 5;
      last[a] = first[a] + below(12);
    }
    bool any = false; // oracle: every cell of the box
    for (int z = first[2]; z <= last[2]; ++z)
      for (int y = first[1]; y <= last[1]; ++y)
        for (int x = first[0]; x <= last[0]; ++x)
          any |= map.has_cell({x, y, z}) && map.is_occupied({x, y, z});
    ASSERT_EQ(map.is_any_occupied(first, last), any);
  }
}

TEST(OccupancyMapContract, AnEmptyWorldCostsLittleAndWhatIsTakenOutIsGivenBack) {
  OccupancyMap map({512, 512, 512});
  EXPECT_LE(map.bytes(), 132 * 1024); // contract: 32^3 bricks of 4 bytes
  for (int z = 0; z < 512; ++z)       // one brick at a time: one brick's memory is enough
    map.put_row({100, 100, z}, 8, 8 * z), map.take_row({100, 100, z}, 8);
  EXPECT_EQ(map.n_occupied(), 0);
  EXPECT_LE(map.bytes(), 160 * 1024);
}

TEST(OccupancyMapContract, TheFirstInACellStays) {
  OccupancyMap map({20, 1, 1});
  map.put({5, 0, 0}, 3);
  map.put_row({4, 0, 0}, 3, 10);
  EXPECT_EQ(map.occupant({4, 0, 0}), 10);
  EXPECT_EQ(map.occupant({5, 0, 0}), 3);
  EXPECT_EQ(map.occupant({6, 0, 0}), 12);
  EXPECT_TRUE(map.is_blocked({20, 0, 0}));
  EXPECT_TRUE(map.is_blocked({0, -1, 0}));
  EXPECT_FALSE(map.is_blocked({0, 0, 0}));
}

// Oracle: a dictionary of cells.
void put_and_take_boxes_as_a_dictionary_does() {
  const Index3 cells{50, 37, 35};
  OccupancyMap map(cells);
  std::map<Index3, VoxelId> truth;
  std::mt19937 random(19);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  VoxelId next = 0;
  for (int round = 0; round < 600; ++round) {
    Index3 first, size;
    for (std::size_t a = 0; a < 3; ++a) {
      first[a] = below(cells[a]);
      size[a] = 1 + below(std::min(20, cells[a] - first[a]));
    }
    const bool puts = below(2) == 0;
    puts ? map.put_box(first, size, next) : map.take_box(first, size);
    for (int z = 0; z < size[2]; ++z)
      for (int y = 0; y < size[1]; ++y)
        for (int x = 0; x < size[0]; ++x) {
          const Index3 at{first[0] + x, first[1] + y, first[2] + z};
          if (puts)
            truth.emplace(at, next + x + size[0] * (y + size[1] * z)); // the first in a cell stays
          else
            truth.erase(at);
        }
    next += size[0] * size[1] * size[2];
    ASSERT_EQ(map.n_occupied(), static_cast<std::int64_t>(truth.size()));
    for (int look = 0; look < 200; ++look) {
      const Index3 at{below(cells[0]), below(cells[1]), below(cells[2])};
      const auto found = truth.find(at);
      ASSERT_EQ(map.occupant(at), found == truth.end() ? no_voxel : found->second) << "round " << round;
    }
  }
}

TEST(OccupancyMapOracle, BoxesPutAndTakenAreThoseOfADictionary) {
  for (const std::int64_t target : tests::vector_targets()) {
    SCOPED_TRACE(target);
    const tests::ForcedVectors forced(target);
    ASSERT_NO_FATAL_FAILURE(put_and_take_boxes_as_a_dictionary_does());
  }
}

// Oracle: a dictionary of cells. Single cells do not go the way of boxes.
TEST(OccupancyMapOracle, CellsPutAndTakenAreThoseOfADictionary) {
  const Index3 cells{18, 17, 3};
  OccupancyMap map(cells);
  std::map<Index3, VoxelId> truth;
  std::mt19937 random(23);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  for (VoxelId id = 0; id < 5000; ++id) {
    const Index3 at{below(cells[0]), below(cells[1]), below(cells[2])};
    if (id / 1000 % 2 == 0 ? below(3) > 0 : below(9) == 0) { // fills the world, then empties it
      map.put(at, id);
      truth.emplace(at, id); // the first in a cell stays
    } else {
      map.take(at);
      truth.erase(at);
    }
    ASSERT_EQ(map.n_occupied(), static_cast<std::int64_t>(truth.size()));
    const Index3 other{below(cells[0]), below(cells[1]), below(cells[2])};
    for (const Index3& look : {at, other}) {
      const auto found = truth.find(look);
      ASSERT_EQ(map.occupant(look), found == truth.end() ? no_voxel : found->second) << "after " << id;
    }
  }
}

// Oracle: cell by cell.
TEST(OccupancyMapOracle, ManyCellsAreCountedAsOneByOne) {
  const Index3 cells{70, 21, 35};
  OccupancyMap map(cells);
  std::mt19937 random(11);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  for (int i = 0; i < 3000; ++i)
    map.put({below(cells[0]), below(cells[1]), below(cells[2])}, i);
  for (const std::int64_t target : tests::vector_targets()) {
    const tests::ForcedVectors forced(target);
    for (int round = 0; round < 200; ++round) {
      std::vector<std::int32_t> at[3];
      const int n = below(100);
      std::int64_t expected = 0;
      for (int i = 0; i < n; ++i) {
        const Index3 cell{below(90) - 10, below(41) - 10, below(55) - 10};
        expected += map.is_blocked(cell);
        for (std::size_t a = 0; a < 3; ++a)
          at[a].push_back(cell[a]);
      }
      const std::int32_t* const places[3] = {at[0].data(), at[1].data(), at[2].data()};
      ASSERT_EQ(map.n_blocked(n, places), expected);
    }
  }
  for (int round = 0; round < 3000; ++round) {
    const Index3 first{below(110) - 20, below(25) - 2, below(39) - 2};
    const int n = 1 + below(60);
    int expected = 0;
    for (int i = 0; i < n; ++i)
      expected += map.is_blocked({first[0] + i, first[1], first[2]});
    ASSERT_EQ(map.n_blocked_in_row(first, n), expected);
    ASSERT_EQ(map.is_row_blocked(first, n), expected > 0);
  }
}

} // namespace
} // namespace maille::deform
