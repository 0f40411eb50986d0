#pragma once
/// Rigid bodies in worlds of cells, and random motions of them.

#include "maille/deform/world/rigid_world.hpp"
#include "support/dice.hpp"

#include <Eigen/Geometry>

#include <numbers>
#include <optional>
#include <vector>

namespace maille::test {

using deform::Pose;
using deform::RigidMotion;
using deform::RigidShape;
using deform::RigidWorld;

inline RigidShape box_shape(const Index3& size, const Vec3& spacing = {1, 1, 1}) {
  return {size, spacing, std::vector<std::uint8_t>(std::size_t(size[0] * size[1] * size[2]), 1)};
}

/// A shape with two thirds of its voxels filled, and the first one.
inline RigidShape porous_shape(Dice& dice, const Index3& size, const Vec3& spacing) {
  std::vector<std::uint8_t> matter(std::size_t(size[0] * size[1] * size[2]));
  for (std::uint8_t& value : matter)
    value = dice.below(3) != 0;
  matter[0] = 1;
  return {size, spacing, matter};
}

/// Adds isolated obstacle cells at random positions.
inline void scatter(RigidWorld& world, int n, Dice& dice) {
  const Index3& cells = world.map().cells();
  for (int i = 0; i < n; ++i) {
    Pose pose;
    for (int a = 0; a < 3; ++a)
      pose.position[a] = dice.below(cells[std::size_t(a)]) * world.cell_size()[std::size_t(a)];
    world.add(box_shape({1, 1, 1}, world.cell_size()), pose);
  }
}

inline RigidMotion random_motion(Dice& dice, double reach, bool turns) {
  RigidMotion motion;
  motion.by = dice.between(0, reach) * dice.direction();
  if (turns) {
    motion.axis = dice.direction();
    motion.angle = dice.between(-std::numbers::pi, std::numbers::pi);
    motion.about = {dice.between(0, 30), dice.between(0, 30), dice.between(0, 30)};
  }
  return motion;
}

struct Question {
  RigidWorld world;
  std::optional<int> object;
};

/// An object at a random position in a world of obstacles, aligned with the world's cells or rotated.
inline Question random_question(Dice& dice, bool aligned) {
  Question question{RigidWorld({34, 40, 30}, {1, 0.75, 1.5}), {}};
  scatter(question.world, 60, dice);
  while (!question.object) {
    Pose pose;
    if (!aligned)
      pose.rotation =
          Eigen::AngleAxisd(dice.between(0, std::numbers::pi), dice.direction()).toRotationMatrix();
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

} // namespace maille::test
