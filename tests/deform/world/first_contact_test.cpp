/// What a moving body meets first, against all its voxels looked at.

#include "world/first_contact.hpp"

#include "support/bodies/rigid_bodies.hpp"
#include "world/occupancy/posed_shape.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace maille::deform {
namespace {

using std::numbers::pi;
using tests::Dice;
using tests::porous_shape;
using tests::Question;
using tests::random_motion;
using tests::random_question;

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

/// An object on its way among what it can meet.
struct Approach {
  RigidWorld world;
  int object;
  RigidMotion motion;
  OccupancyMap others = map_without(world, object);
  const RigidShape& shape() const { return world.shape(object); }
  const Pose& pose() const { return world.pose(object); }
  std::optional<Contact> first_contact() const {
    return deform::first_contact(others, world.cell_size(), shape(), pose(), motion);
  }
};

Approach random_approach(Dice& dice, bool aligned, double reach, bool turns) {
  Question question = random_question(dice, aligned);
  return {std::move(question.world), *question.object, random_motion(dice, reach, turns)};
}

// Oracle: all cells of all voxels, without leaving out what cannot be first.
TEST(RigidWorldOracle, TheFirstContactIsThatOfEveryVoxel) {
  std::mt19937 random(5);
  Dice dice{random};
  int met = 0;
  for (int round = 0; round < 300; ++round) {
    const Approach way = random_approach(dice, round % 2 == 0, 30, round % 4 > 1);
    const auto fast = way.first_contact();
    const auto every =
        first_contact_of_every_voxel(way.others, way.world.cell_size(), way.shape(), way.pose(), way.motion);
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

// Oracle: the middles of voxels looked at at many times: free before the contact, blocked in the contact's
// cell just behind it.
TEST(RigidWorldOracle, NothingIsMetBeforeTheFirstContact) {
  std::mt19937 random(6);
  Dice dice{random};
  for (int round = 0; round < 200; ++round) {
    const Approach way = random_approach(dice, round % 2 == 0, 15, round % 4 > 1);
    const Vec3& cell_size = way.world.cell_size();
    const auto contact = way.first_contact();
    const double end = contact ? contact->time - 1e-9 : 1;
    for (int i = 0; i < 60; ++i) {
      const double t = end * (i + 0.5) / 60;
      const PosedShape posed(way.shape(), way.motion.moved(way.pose(), t), cell_size);
      ASSERT_FALSE(any_voxel(posed, 0, way.shape().n_voxels(),
                             [&](std::int32_t, const Index3& cell) { return way.others.is_blocked(cell); }))
          << "round " << round;
    }
    if (contact && contact->time < 1 - 1e-9) {
      const Pose behind = way.motion.moved(way.pose(), contact->time + 1e-9);
      ASSERT_EQ(PosedShape(way.shape(), behind, cell_size).cell(contact->voxel), contact->cell);
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

} // namespace
} // namespace maille::deform
