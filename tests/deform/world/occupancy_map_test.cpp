#include "maille/deform/world/occupancy_map.hpp"
#include "maille/deform/world/world.hpp"
#include "support/bodies/rigid_bodies.hpp"
#include "support/kit.hpp"
#include "support/vector_targets.hpp"
#include "support/worlds/worlds.hpp"
#include "world/occupancy/cell_walk.hpp"
#include "world/occupancy/first_contact.hpp"
#include "world/occupancy/posed_shape.hpp"

namespace maille::deform {
namespace {

TEST(OccupancyMapOracle, BoxesAreSearchedToTheCell) {
  const Index3 cells{40, 40, 40};
  OccupancyMap map(cells);
  std::mt19937 random(11);
  const auto below = [&](int n) { return int(random() % unsigned(n)); };
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
    map.put_box({100, 100, z}, {8, 1, 1}, 8 * z), map.take_box({100, 100, z}, {8, 1, 1});
  EXPECT_EQ(map.n_occupied(), 0);
  EXPECT_LE(map.bytes(), 160 * 1024);
}

TEST(OccupancyMapContract, TheFirstInACellStays) {
  OccupancyMap map({20, 1, 1});
  map.put({5, 0, 0}, 3);
  map.put_box({4, 0, 0}, {3, 1, 1}, 10);
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
  const auto below = [&](int n) { return int(random() % unsigned(n)); };
  VoxelId next = 0;
  for (int round = 0; round < 600; ++round) {
    Index3 first, size;
    for (std::size_t a = 0; a < 3; ++a) {
      first[a] = below(cells[a]);
      const int most = round % 2 == 0 ? 20 : a == 0 ? cells[0] : 1; // every other time a row
      size[a] = 1 + below(std::min(most, cells[a] - first[a]));
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
    ASSERT_EQ(map.n_occupied(), std::int64_t(truth.size()));
    for (int look = 0; look < 200; ++look) {
      const Index3 at{below(cells[0]), below(cells[1]), below(cells[2])};
      const auto found = truth.find(at);
      ASSERT_EQ(map.occupant(at), found == truth.end() ? no_voxel : found->second) << "round " << round;
    }
  }
}

TEST(OccupancyMapOracle, BoxesPutAndTakenAreThoseOfADictionary) {
  for (const std::int64_t target : test::vector_targets()) {
    SCOPED_TRACE(target);
    const test::ForcedVectors forced(target);
    ASSERT_NO_FATAL_FAILURE(put_and_take_boxes_as_a_dictionary_does());
  }
}

// Oracle: a dictionary of cells. Single cells do not go the way of boxes.
TEST(OccupancyMapOracle, CellsPutAndTakenAreThoseOfADictionary) {
  const Index3 cells{18, 17, 3};
  OccupancyMap map(cells);
  std::map<Index3, VoxelId> truth;
  std::mt19937 random(23);
  const auto below = [&](int n) { return int(random() % unsigned(n)); };
  for (VoxelId id = 0; id < 5000; ++id) {
    const Index3 at{below(cells[0]), below(cells[1]), below(cells[2])};
    if (id / 1000 % 2 == 0 ? below(3) > 0 : below(9) == 0) { // fills the world, then empties it
      map.put(at, id);
      truth.emplace(at, id); // the first in a cell stays
    } else {
      map.take(at);
      truth.erase(at);
    }
    ASSERT_EQ(map.n_occupied(), std::int64_t(truth.size()));
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
  const auto below = [&](int n) { return int(random() % unsigned(n)); };
  for (int i = 0; i < 3000; ++i)
    map.put({below(cells[0]), below(cells[1]), below(cells[2])}, i);
  for (const std::int64_t target : test::vector_targets()) {
    const test::ForcedVectors forced(target);
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

using std::numbers::pi;
using test::Dice;
using test::porous_shape;
using test::Question;
using test::random_motion;
using test::random_question;

/// The same world without the object.
OccupancyMap map_without(const RigidWorld& world, int object) {
  OccupancyMap map(world.map().cells());
  for (int other = 0; other < world.n_objects(); ++other)
    if (other != object)
      any_voxel(PosedShape(world.shape(other), world.pose(other), world.cell_size()), 0,
                world.shape(other).n_voxels(), [&](std::int32_t, const Index3& cell) {
                  map.put(cell, other);
                  return false;
                });
  return map;
}

// Oracle: the middles of voxels looked at at many times: free before the contact, blocked in the contact's
// cell just behind it.
TEST(RigidWorldOracle, NothingIsMetBeforeTheFirstContact) {
  std::mt19937 random(6);
  Dice dice{random};
  int met = 0;
  for (int round = 0; round < 300; ++round) {
    const Question question = random_question(dice, round % 2 == 0);
    const RigidWorld& world = question.world;
    const RigidMotion motion = random_motion(dice, round % 8 < 4 ? 15 : 30, round % 4 > 1);
    const OccupancyMap others = map_without(world, *question.object);
    const RigidShape& shape = world.shape(*question.object);
    const Pose& pose = world.pose(*question.object);
    const Vec3& cell_size = world.cell_size();
    const auto contact = first_contact(others, cell_size, shape, pose, motion);
    const double end = contact ? contact->time - 1e-9 : 1;
    met += contact.has_value();
    for (int i = 0; i < 200; ++i) {
      const double t = end * (i + 0.5) / 200;
      const PosedShape posed(shape, motion.moved(pose, t), cell_size);
      ASSERT_FALSE(any_voxel(posed, 0, shape.n_voxels(),
                             [&](std::int32_t, const Index3& cell) { return others.is_blocked(cell); }))
          << "round " << round;
    }
    if (contact && contact->time < 1 - 1e-9) {
      const Pose behind = motion.moved(pose, contact->time + 1e-9);
      ASSERT_EQ(PosedShape(shape, behind, cell_size).cell(contact->voxel), contact->cell);
      ASSERT_TRUE(others.is_blocked(contact->cell)) << "round " << round;
    }
  }
  EXPECT_GT(met, 100); // else nothing was tested
}

// Oracle: voxel by voxel. Aligned shapes are counted row by row, others many cells at a time.
TEST(RigidWorldOracle, BlockedVoxelsAreCountedAsOneByOne) {
  std::mt19937 random(13);
  Dice dice{random};
  for (int round = 0; round < 200; ++round) {
    const bool aligned = round % 2 == 0;
    const Question question = random_question(dice, aligned);
    const RigidWorld& world = question.world;
    const RigidShape shape = porous_shape(dice, {1 + dice.below(40), 1 + dice.below(9), 1 + dice.below(9)},
                                          aligned ? Vec3{1, 0.75, 1.5} : Vec3{0.7, 0.6, 1.1});
    Pose pose;
    if (!aligned)
      pose.rotation = Eigen::AngleAxisd(dice.between(0, pi), dice.direction()).toRotationMatrix();
    pose.position = {dice.between(-20, 40), dice.between(-10, 30), dice.between(-10, 40)};
    std::int32_t expected = 0;
    any_voxel(PosedShape(shape, pose, world.cell_size()), 0, shape.n_voxels(),
              [&](std::int32_t, const Index3& cell) {
                expected += world.map().is_blocked(cell);
                return false;
              });
    ASSERT_EQ(world.n_blocked(shape, pose), expected) << "round " << round;
    ASSERT_EQ(is_blocked(world.map(), world.cell_size(), shape, pose), expected > 0) << "round " << round;
  }
}

Index3 cell_at(const std::array<CoordinatePath, 3>& paths, double angle, double t) {
  return {int(std::floor(paths[0].at(t, angle))), int(std::floor(paths[1].at(t, angle))),
          int(std::floor(paths[2].at(t, angle)))};
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
        cell[std::size_t(step->axis)] += step->direction;
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
