#include "maille/deform/world/rigid_world.hpp"

#include "support/dice.hpp"
#include "support/vector_targets.hpp"
#include "world/first_contact.hpp"
#include "world/posed_shape.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <set>

namespace maille::deform {
namespace {

using std::numbers::pi;
using tests::Dice;

RigidShape box_shape(const Index3& size, const Vec3& spacing = {1, 1, 1}) {
  return {size, spacing, std::vector<std::uint8_t>(static_cast<std::size_t>(size[0] * size[1] * size[2]), 1)};
}

/// Two voxels of three are matter, and the first.
RigidShape porous_shape(Dice& dice, const Index3& size, const Vec3& spacing) {
  std::vector<std::uint8_t> matter(static_cast<std::size_t>(size[0] * size[1] * size[2]));
  for (std::uint8_t& value : matter)
    value = dice.below(3) != 0;
  matter[0] = 1;
  return {size, spacing, matter};
}

/// Lonely cells here and there.
void scatter(RigidWorld& world, int n, Dice& dice) {
  const Index3& cells = world.map().cells();
  for (int i = 0; i < n; ++i) {
    Pose pose;
    for (int a = 0; a < 3; ++a)
      pose.position[a] =
          dice.below(cells[static_cast<std::size_t>(a)]) * world.cell_size()[static_cast<std::size_t>(a)];
    world.add(box_shape({1, 1, 1}, world.cell_size()), pose);
  }
}

RigidMotion random_motion(Dice& dice, double reach, bool turns) {
  RigidMotion motion;
  motion.by = dice.between(0, reach) * dice.direction();
  if (turns) {
    motion.axis = dice.direction();
    motion.angle = dice.between(-pi, pi);
    motion.about = {dice.between(0, 30), dice.between(0, 30), dice.between(0, 30)};
  }
  return motion;
}

struct Question {
  RigidWorld world;
  std::optional<int> object;
};

/// An object somewhere in a world of obstacles, aligned with the world's cells or turned.
Question random_question(Dice& dice, bool aligned) {
  Question question{RigidWorld({34, 40, 30}, {1, 0.75, 1.5}), {}};
  scatter(question.world, 60, dice);
  while (!question.object) {
    Pose pose;
    if (!aligned)
      pose.rotation = Eigen::AngleAxisd(dice.between(0, pi), dice.direction()).toRotationMatrix();
    pose.position = {dice.between(5, 25), dice.between(5, 20), dice.between(8, 30)};
    const Vec3 spacing = aligned ? Vec3{1, 0.75, 1.5} : Vec3{0.9, 0.7, 1.3};
    question.object =
        question.world
            .add(porous_shape(dice, {1 + dice.below(20), 1 + dice.below(9), 1 + dice.below(6)}, spacing),
                 pose)
            .object;
  }
  return question;
}

/// The same world without the object.
OccupancyMap map_without(const RigidWorld& world, int object) {
  OccupancyMap map = [&] {
    OccupancyMap empty(world.map().cells());
    return empty;
  }();
  for (int other = 0; other < world.n_objects(); ++other)
    if (other != object)
      any_voxel(PosedShape(world.shape(other), world.pose(other), world.cell_size()), 0,
                world.shape(other).n_voxels(), [&](std::int32_t, const Index3& cell) {
                  map.put(cell, other);
                  return false;
                });
  return map;
}

// Oracle: all cells of all voxels, without leaving out what cannot be first.
TEST(RigidWorldOracle, TheFirstContactIsThatOfEveryVoxel) {
  std::mt19937 random(5);
  Dice dice{random};
  int met = 0;
  for (int round = 0; round < 300; ++round) {
    const bool aligned = round % 2 == 0;
    const Question question = random_question(dice, aligned);
    const RigidWorld& world = question.world;
    const RigidMotion motion = random_motion(dice, 30, round % 4 > 1);
    const OccupancyMap map = map_without(world, *question.object);
    const RigidShape& shape = world.shape(*question.object);
    const Pose& pose = world.pose(*question.object);
    const auto fast = first_contact(map, world.cell_size(), shape, pose, motion);
    const auto every = first_contact_of_every_voxel(map, world.cell_size(), shape, pose, motion);
    ASSERT_EQ(fast.has_value(), every.has_value()) << "round " << round;
    if (!fast)
      continue;
    ++met;
    ASSERT_EQ(fast->time, every->time) << "round " << round;
    ASSERT_EQ(fast->voxel, every->voxel) << "round " << round;
    ASSERT_EQ(fast->cell, every->cell) << "round " << round;
  }
  EXPECT_GT(met, 100); // else nothing was tested
}

// Oracle: the pose looked at at many times: free before the contact, blocked in the contact's cell just behind it.
TEST(RigidWorldOracle, NothingIsMetBeforeTheFirstContact) {
  std::mt19937 random(6);
  Dice dice{random};
  for (int round = 0; round < 200; ++round) {
    const Question question = random_question(dice, round % 2 == 0);
    const RigidWorld& world = question.world;
    const RigidMotion motion = random_motion(dice, 15, round % 4 > 1);
    const OccupancyMap map = map_without(world, *question.object);
    const RigidShape& shape = world.shape(*question.object);
    const Pose& pose = world.pose(*question.object);
    const auto contact = first_contact(map, world.cell_size(), shape, pose, motion);
    const double end = contact ? contact->time - 1e-9 : 1;
    for (int i = 0; i < 60; ++i) {
      const double t = end * (i + 0.5) / 60;
      ASSERT_FALSE(is_blocked(map, world.cell_size(), shape, motion.moved(pose, t))) << "round " << round;
    }
    if (contact && contact->time < 1 - 1e-9) {
      const Pose behind = motion.moved(pose, contact->time + 1e-9);
      ASSERT_EQ(PosedShape(shape, behind, world.cell_size()).cell(contact->voxel), contact->cell);
    }
  }
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

// Contract: the map always holds exactly the objects where they are, and no two objects share a cell.
TEST(RigidWorldContract, NoObjectEverEntersAnother) {
  std::mt19937 random(8);
  Dice dice{random};
  RigidWorld world({48, 48, 48}, {1, 1, 1});
  for (int i = 0; i < 12; ++i) {
    Pose pose;
    pose.position = {dice.between(2, 36), dice.between(2, 36), dice.between(2, 36)};
    pose.rotation =
        Eigen::AngleAxisd(i % 3 == 0 ? 0 : dice.between(0, pi), dice.direction()).toRotationMatrix();
    world.add(porous_shape(dice, {8, 8, 8}, {1, 1, 1}), pose);
  }
  ASSERT_GT(world.n_objects(), 4);
  int contacts = 0;
  for (int round = 0; round < 600; ++round) {
    const int object = dice.below(world.n_objects());
    RigidMotion motion = random_motion(dice, 20, round % 2 == 0);
    motion.about = world.pose(object).position;
    const MoveResult result = round % 3 == 0 ? world.slide(object, motion) : world.move(object, motion);
    contacts += static_cast<int>(result.contacts.size());
    std::set<Index3> taken;
    for (int other = 0; other < world.n_objects(); ++other) {
      std::set<Index3> own;
      any_voxel(PosedShape(world.shape(other), world.pose(other), world.cell_size()), 0,
                world.shape(other).n_voxels(), [&](std::int32_t, const Index3& cell) {
                  EXPECT_TRUE(world.map().has_cell(cell));
                  EXPECT_EQ(world.object_of(world.map().occupant(cell)), other);
                  own.insert(cell);
                  return false;
                });
      taken.merge(own);
      ASSERT_TRUE(own.empty()) << "two objects in one cell";
    }
    ASSERT_EQ(world.map().n_occupied(), static_cast<std::int64_t>(taken.size()));
  }
  EXPECT_GT(contacts, 200);
}

TEST(RigidWorldAnalytic, AThinWallStopsAnythingAtAnySpeed) {
  for (const double speed : {1.0, 7.5, 90.0}) {
    RigidWorld world({100, 9, 9}, {1, 1, 1});
    Pose wall;
    wall.position = {60, 0, 0};
    ASSERT_TRUE(world.add(box_shape({1, 9, 9}), wall).object);
    Pose start;
    start.position = {2, 3, 3};
    const int cube = *world.add(box_shape({3, 3, 3}), start).object;
    RigidMotion motion;
    motion.by = {speed, 0, 0};
    for (double done = 0; done < 95; done += speed)
      world.move(cube, motion);
    EXPECT_NEAR(world.pose(cube).position[0], 57.5,
                1e-6); // analytic: the last centre, 2.5 further, reaches 60
    // Gibson's rule lands behind the wall, because nothing is there.
    const int other = *world.add(box_shape({1, 1, 1}), Pose{.position = {2, 0, 0}}).object;
    motion.by = {80, 0, 0};
    EXPECT_EQ(world.move_by_halving(other, motion).fraction, 1);
  }
}

TEST(RigidWorldAnalytic, WhatSlidesKeepsTheShiftAlongTheWall) {
  RigidWorld world({40, 40, 40}, {1, 1, 1});
  const int cube = *world.add(box_shape({2, 2, 2}), Pose{.position = {10, 10, 10}}).object;
  RigidMotion motion;
  motion.by = {60, 5, -3}; // the border of the world stops it along x
  const MoveResult result = world.slide(cube, motion);
  ASSERT_EQ(result.contacts.size(), 1u);
  EXPECT_EQ(result.contacts[0].axis, 0);
  EXPECT_EQ(result.contacts[0].other, nobody);
  EXPECT_NEAR((world.pose(cube).position - Eigen::Vector3d(38.5, 15, 7)).norm(), 0,
              1e-6); // centre 1.5 further: 40
}

TEST(RigidWorldAnalytic, ATurningBarMeetsAPegAtItsAngle) {
  RigidWorld world({64, 64, 1}, {1, 1, 1});
  // Centres at distance 1 to 20 from (32.5, 32.5) along x; the peg is the cell [45, 46) x [40, 41).
  const int bar = *world.add(box_shape({20, 1, 1}), Pose{.position = {33, 32, 0}}).object;
  ASSERT_TRUE(world.add(box_shape({1, 1, 1}), Pose{.position = {45, 40, 0}}).object);
  RigidMotion motion;
  motion.angle = pi / 2;
  motion.about = {32.5, 32.5, 0};
  const MoveResult result = world.move(bar, motion);
  ASSERT_EQ(result.contacts.size(), 1u);
  // Analytic: over all r = 1 to 20 the first time that 32.5 + r (cos, sin) lies in the peg.
  double expected = 2;
  for (int r = 1; r <= 20; ++r)
    for (const double angle : {std::asin(7.5 / r), std::acos(13.5 / r)}) {
      const double x = r * std::cos(angle), y = r * std::sin(angle), hair = 1e-9;
      if (x > 12.5 - hair && x < 13.5 + hair && y > 7.5 - hair && y < 8.5 + hair)
        expected = std::min(expected, angle / (pi / 2));
    }
  EXPECT_NEAR(result.contacts[0].time, expected, 1e-12);
}

TEST(RigidWorldContract, AMotionBackComesHome) {
  // Contract: a turn there and back again is the identity to rounding; without contact nothing is lost.
  RigidWorld world({64, 64, 64}, {1, 1, 1});
  const int cube = *world.add(box_shape({10, 4, 4}), Pose{.position = {30, 30, 30}}).object;
  const Pose before = world.pose(cube);
  RigidMotion motion;
  motion.axis = Eigen::Vector3d(1, 2, 3).normalized();
  motion.about = {33, 33, 33};
  motion.angle = 0.3;
  RigidMotion back = motion;
  back.angle = -0.3;
  for (int i = 0; i < 1000; ++i) {
    ASSERT_TRUE(world.move(cube, motion).contacts.empty());
    ASSERT_TRUE(world.move(cube, back).contacts.empty());
  }
  EXPECT_LT((world.pose(cube).position - before.position).norm(), 1e-11);
  EXPECT_LT((world.pose(cube).rotation - before.rotation).norm(), 1e-12);
}

TEST(RigidWorldContract, VectorsOfAnyLengthGiveTheSameCells) {
  std::mt19937 random(9);
  Dice dice{random};
  const RigidShape shape = porous_shape(dice, {33, 17, 9}, {0.7, 0.8, 0.9});
  Pose pose;
  pose.rotation = Eigen::AngleAxisd(1, dice.direction()).toRotationMatrix();
  pose.position = {20, 20, 20};
  std::vector<std::vector<Index3>> answers;
  for (const std::int64_t target : tests::vector_targets()) {
    const tests::ForcedVectors forced(target);
    std::vector<Index3>& cells = answers.emplace_back();
    any_voxel(PosedShape(shape, pose, {1, 1, 1}), 0, shape.n_voxels(), [&](std::int32_t, const Index3& cell) {
      cells.push_back(cell);
      return false;
    });
    EXPECT_EQ(cells, answers.front());
  }
}

TEST(RigidWorldContract, AnObjectIsNotPutWhereSomethingIs) {
  RigidWorld world({20, 20, 20}, {1, 1, 1});
  ASSERT_TRUE(world.add(box_shape({4, 4, 4}), Pose{.position = {8, 8, 8}}).object);
  const auto added = world.add(box_shape({4, 4, 4}), Pose{.position = {11, 8, 8}});
  EXPECT_FALSE(added.object);
  ASSERT_TRUE(added.refused_at);
  EXPECT_EQ(world.object_of(added.refused_at->other), 0);
  EXPECT_EQ(world.map().n_occupied(), 64);
  EXPECT_FALSE(world.add(box_shape({4, 4, 4}), Pose{.position = {17, 0, 0}}).object); // through the border
}

// Oracle: where a flood of whole steps can come to. A piece in a maze, thrown about in steps of any size, is never anywhere else.
TEST(RigidWorldOracle, APieceStaysInItsPartOfTheMaze) {
  const char* const rows[] = {"#####################", "#   #       #   #   #", "#   # ##### # # # # #",
                              "# #   #   # # # # # #", "# ##### # # # # # # #", "#       # #   #   # #",
                              "######### ######### #", "#       #           #", "# ##### #############",
                              "#     # #     #     #", "#####################"};
  const Index3 cells{21, 11, 1};
  std::vector<std::uint8_t> walls;
  for (const char* row : rows)
    for (const char* c = row; *c != 0; ++c)
      walls.push_back(*c == '#');
  RigidWorld world(cells, {1, 1, 1});
  ASSERT_TRUE(world.add(RigidShape(cells, {1, 1, 1}, walls), {}).object);
  const int piece = *world.add(box_shape({1, 1, 1}), Pose{.position = {1, 1, 0}}).object;
  std::set<Index3> reachable;
  std::vector<Index3> front{{1, 1, 0}};
  while (!front.empty()) {
    const Index3 at = front.back();
    front.pop_back();
    if (walls[static_cast<std::size_t>(at[0] + 21 * at[1])] != 0 || !reachable.insert(at).second)
      continue;
    for (const Index3 step : {Index3{1, 0, 0}, Index3{-1, 0, 0}, Index3{0, 1, 0}, Index3{0, -1, 0}})
      front.push_back({at[0] + step[0], at[1] + step[1], 0});
  }
  std::mt19937 random(12);
  Dice dice{random};
  std::set<Index3> visited;
  for (int round = 0; round < 20000; ++round) {
    const double angle = dice.between(0, 2 * pi), size = std::pow(10, dice.between(-2, 2));
    RigidMotion motion;
    motion.by = {size * std::cos(angle), size * std::sin(angle), 0};
    world.slide(piece, motion);
    const Index3 cell = PosedShape(world.shape(piece), world.pose(piece), {1, 1, 1}).cell(0);
    ASSERT_TRUE(reachable.contains(cell)) << cell[0] << ' ' << cell[1] << " in round " << round;
    visited.insert(cell);
  }
  EXPECT_GT(visited.size(), reachable.size() / 3); // it does get about
  EXPECT_LT(reachable.size(), 120u);               // and there are parts that it must not come to
}

} // namespace
} // namespace maille::deform
