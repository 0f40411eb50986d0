#include "maille/deform/world/rigid_world.hpp"

#include "support/bodies/rigid_bodies.hpp"
#include "support/vector_targets.hpp"
#include "world/occupancy/posed_shape.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <set>

namespace maille::deform {
namespace {

using std::numbers::pi;
using tests::box_shape;
using tests::Dice;
using tests::porous_shape;
using tests::random_motion;

/// The cells whose middles lie in a shape's voxels as boxes, looked for about each voxel.
std::set<Index3> cells_in_matter(const RigidShape& shape, const Pose& pose) {
  std::set<Index3> cells;
  for (std::int32_t voxel = 0; voxel < shape.n_voxels(); ++voxel) {
    const Index3 i = shape.index_of(voxel);
    const Eigen::Vector3d middle =
        pose.position + pose.rotation * Eigen::Vector3d(i[0] + 0.5, i[1] + 0.5, i[2] + 0.5);
    for (int near = 0; near < 27; ++near) {
      const Index3 cell{static_cast<int>(std::floor(middle[0])) + near % 3 - 1,
                        static_cast<int>(std::floor(middle[1])) + near / 3 % 3 - 1,
                        static_cast<int>(std::floor(middle[2])) + near / 9 - 1};
      const Eigen::Vector3d off =
          pose.rotation.transpose() * (Eigen::Vector3d(cell[0] + 0.5, cell[1] + 0.5, cell[2] + 0.5) - middle);
      if (off.cwiseAbs().maxCoeff() < 0.5)
        cells.insert(cell);
    }
  }
  return cells;
}

// Contract: the map always holds exactly the objects where they are, with the cells whose middles are in
// their boxes, and no two objects share a cell.
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
  for (int round = 0; round < 400; ++round) {
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
      for (const Index3& cell : cells_in_matter(world.shape(other), world.pose(other)))
        if (world.map().has_cell(cell)) // a voxel's box may reach over the border, its middle may not
          own.insert(cell);
      taken.merge(own);
      ASSERT_TRUE(own.empty()) << "two objects in one cell";
    }
    ASSERT_EQ(world.map().n_occupied(), static_cast<std::int64_t>(taken.size()));
  }
  EXPECT_GT(contacts, 130);
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

// Oracle: Gibson's rule, which tests whole poses. Of its steps, those before the exact first contact are
// free; and a step that is blocked is behind it.
TEST(RigidWorldOracle, HalvedStepsBeforeTheFirstContactAreFree) {
  std::uniform_real_distribution<double> unit(-1, 1);
  int cut = 0;
  for (unsigned round = 0; round < 2000; ++round) {
    RigidWorld exact({24, 24, 24}, {1, 1, 1}), halved({24, 24, 24}, {1, 1, 1});
    std::mt19937 random(round);
    std::optional<int> object;
    for (int i = 0; i < 12 || !object; ++i) {
      const Pose pose{.position = {10 + 9 * unit(random), 10 + 9 * unit(random), 10 + 9 * unit(random)}};
      object = exact.add(box_shape({2 + i % 3, 3, 2}), pose).object;
      ASSERT_EQ(halved.add(box_shape({2 + i % 3, 3, 2}), pose).object, object);
    }
    RigidMotion motion;
    motion.by = 12 * Eigen::Vector3d(unit(random), unit(random), unit(random));
    const double fraction = exact.move(*object, motion).fraction;
    const double step = halved.move_by_halving(*object, motion, 1e-6).fraction;
    cut += fraction < 1;
    if (fraction >= 1e-5) {
      EXPECT_GE(step, std::exp2(std::floor(std::log2(fraction)))) << "round " << round;
    }
    if (step < 1) { // twice the step is blocked
      EXPECT_LT(fraction, 2 * step + 1e-5) << "round " << round;
    }
  }
  EXPECT_GT(cut, 300);
}

TEST(RigidWorldAnalytic, WhatSlidesKeepsTheShiftAlongTheWall) {
  RigidWorld world({40, 40, 40}, {1, 1, 1});
  const int cube = *world.add(box_shape({2, 2, 2}), Pose{.position = {10, 10, 10}}).object;
  RigidMotion motion;
  motion.by = {60, 5, -3}; // the border of the world stops it along x
  const MoveResult result = world.slide(cube, motion);
  ASSERT_EQ(result.contacts.size(), 1u);
  EXPECT_EQ(result.contacts[0].axis, 0);
  EXPECT_EQ(result.contacts[0].other, no_voxel);
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
  // And the first time that the bar's side, half a cell from its middle line, comes over the peg's middle,
  // which is (13, 8) away.
  expected = std::min(expected, (std::atan2(8, 13) - std::asin(0.5 / std::hypot(13, 8))) / (pi / 2));
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

// Oracle: where a flood of whole steps can come to. A piece in a maze, thrown about in steps of any size, is
// never anywhere else.
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
