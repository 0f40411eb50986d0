#include "maille/deform/world/rigid_world.hpp"

#include "support/bodies/rigid_bodies.hpp"
#include "support/kit.hpp"

#include <Eigen/Geometry>

namespace maille::deform {
namespace {

using std::numbers::pi;
using test::box_shape;
using test::Dice;

/// A box of matter as geometry knows it, without voxels, cells or a map.
struct Slab {
  Pose pose;            ///< of its lowest corner
  Eigen::Vector3d size; ///< [m]

  Eigen::Vector3d within(const Eigen::Vector3d& x) const {
    return pose.rotation.transpose() * (x - pose.position);
  }
  /// Whether a straight way comes in through one of the two large faces (across axis 2), no nearer to their
  /// edges than `edge`, and out through the other.
  bool is_crossed(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double edge) const {
    const Eigen::Vector3d a = within(from), b = within(to);
    if ((a[2] < 0) == (b[2] < 0) || (a[2] < size[2]) == (b[2] < size[2]))
      return false;
    for (const double face : {0.0, size[2]}) {
      const Eigen::Vector3d x = a + (face - a[2]) / (b[2] - a[2]) * (b - a);
      for (const int axis : {0, 1})
        if (x[axis] < edge || x[axis] > size[axis] - edge)
          return false;
    }
    return true;
  }
  /// How deep a point lies in it [m]; below 0 outside.
  double depth(const Eigen::Vector3d& x) const {
    const Eigen::Vector3d at = within(x);
    return std::min(at.minCoeff(), (size - at).minCoeff());
  }
};

Pose random_pose(Dice& dice, const Eigen::Vector3d& middle, const Eigen::Vector3d& size, bool is_turned) {
  Pose pose;
  if (is_turned)
    pose.rotation = Eigen::AngleAxisd(dice.between(0, pi), dice.direction()).toRotationMatrix();
  pose.position = middle - pose.rotation * (0.5 * size);
  return pose;
}

// Independent: the box of the slab, which knows no cells. Slabs one to three voxels thick, of voxels of a
// quarter of a cell to four cells, at any turn, are never passed by a tool of one voxel, whichever of the two
// moves.
TEST(MatterIndependent, NothingPassesASlabAtAnyTurnAndSpacing) {
  int n_paths = 0, n_stopped = 0, n_aimed = 0;
  for (unsigned seed = 0; seed < 240; ++seed) {
    std::mt19937 random(seed);
    Dice dice{random};
    const double ratio = std::array{0.25, 0.4, 0.7, 1.0, 1.0, 1.5, 2.0, 4.0}[seed % 8];
    const double tip_ratio = std::array{0.25, 0.7, 1.0, 1.3, 3.0}[seed / 8 % 5];
    const int thick = 1 + int(seed % 3), wide = int(std::ceil(12 / ratio));
    const Vec3 spacing{ratio, ratio, ratio}, tip_spacing{tip_ratio, tip_ratio, tip_ratio};
    const Eigen::Vector3d middle = Eigen::Vector3d::Constant(24) + 0.5 * dice.direction();
    Slab slab;
    slab.size = Eigen::Vector3d(wide, wide, thick) * ratio;
    slab.pose = random_pose(dice, middle, slab.size, seed % 5 != 0);
    RigidWorld world({48, 48, 48}, {1, 1, 1});
    const int plate = *world
                           .add(RigidShape({wide, wide, thick}, spacing,
                                           std::vector<std::uint8_t>(std::size_t(wide * wide * thick), 1)),
                                slab.pose)
                           .object;
    const Eigen::Vector3d tip_size = Eigen::Vector3d::Constant(tip_ratio);
    std::optional<int> tip;
    const auto middle_of = [&](const Pose& pose) {
      return Eigen::Vector3d(pose.position + pose.rotation * (0.5 * tip_size));
    };
    while (!tip)
      tip = world
                .add(RigidShape({1, 1, 1}, tip_spacing, std::vector<std::uint8_t>{1}),
                     random_pose(dice, middle + 12 * dice.direction(), tip_size, seed % 2 == 0))
                .object;
    for (int path = 0; path < 30; ++path, ++n_paths) {
      // Towards a place in the slab and beyond it, then on from wherever it has come to.
      const Eigen::Vector3d from = middle_of(world.pose(*tip));
      const Eigen::Vector3d aim =
          slab.pose.position +
          slab.pose.rotation * slab.size.cwiseProduct(Eigen::Vector3d(
                                   dice.between(0.1, 0.9), dice.between(0.1, 0.9), dice.between(0, 1)));
      RigidMotion motion;
      motion.by = path % 2 == 0 ? Eigen::Vector3d((aim - from) * dice.between(1, 3))
                                : Eigen::Vector3d(dice.between(2, 12) * dice.direction());
      const bool moves_slab = path % 6 == 5;
      const Slab before = slab;
      if (moves_slab) {
        motion.by = -motion.by;
        motion.by *= std::min(1.0, 6 / motion.by.norm()); // it stays in the world
      }
      n_aimed += slab.is_crossed(from, from + (moves_slab ? -1.0 : 1.0) * motion.by, 1.8);
      const MoveResult result = world.move(moves_slab ? plate : *tip, motion);
      slab.pose = world.pose(plate);
      n_stopped += result.contacts.empty() ? 0 : 1;
      const Eigen::Vector3d to = middle_of(world.pose(*tip));
      const Eigen::Vector3d seen = moves_slab ? Eigen::Vector3d(from - result.fraction * motion.by) : to;
      ASSERT_FALSE(before.is_crossed(from, seen, 1.8))
          << "seed " << seed << ", path " << path << ", spacing " << ratio << ", tip " << tip_ratio;
      // Half a cell's diagonal: the middle of a cell that the tip's middle lies in is not in the slab.
      ASSERT_LT(slab.depth(to), 0.5 * std::sqrt(3.0) + 1e-6) << "seed " << seed << ", path " << path;
    }
  }
  EXPECT_GE(n_paths, 5000);
  EXPECT_GT(n_aimed, 1000) << "these would have passed with nothing in the way";
  EXPECT_GT(n_stopped, 1000);
}

// Contract: every cell whose middle is in an object's matter is the object's; judged by the box, not by
// voxels.
TEST(MatterContract, CellsWhoseMiddlesAreInABoxAreItsOwn) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    std::mt19937 random(seed);
    Dice dice{random};
    const double ratio = std::array{0.25, 0.6, 1.0, 1.4, 2.0, 4.0}[seed % 6];
    const int n = int(std::ceil(8 / ratio));
    Slab box;
    box.size = Eigen::Vector3d::Constant(n * ratio);
    box.pose = random_pose(dice, {12.3, 12.1, 11.8}, box.size, seed % 4 != 0);
    RigidWorld world({24, 24, 24}, {1, 1, 1});
    ASSERT_TRUE(world
                    .add(RigidShape({n, n, n}, {ratio, ratio, ratio},
                                    std::vector<std::uint8_t>(std::size_t(n * n * n), 1)),
                         box.pose)
                    .object);
    for (int z = 0; z < 24; ++z)
      for (int y = 0; y < 24; ++y)
        for (int x = 0; x < 24; ++x) {
          const double depth = box.depth({x + 0.5, y + 0.5, z + 0.5});
          if (depth > 1e-9) {
            ASSERT_TRUE(world.map().is_occupied({x, y, z})) << "seed " << seed;
          }
          if (depth < -0.5 * std::sqrt(3.0) - 1e-9) { // no point of the cell is in the box
            ASSERT_FALSE(world.map().is_occupied({x, y, z})) << "seed " << seed;
          }
        }
  }
}

// Analytic: beyond the border the middle of the first cell is half a cell out. A voxel of four cells comes to
// there with its face, as to the middle of a taken cell, not with its own middle; turned by an eighth of a
// circle it is half a diagonal wide each way.
TEST(MatterAnalytic, TheBorderIsAWallForVoxelsLongerThanCells) {
  RigidWorld world({20, 20, 1}, {1, 1, 1});
  const RigidShape voxel({1, 1, 1}, {4, 4, 1}, std::vector<std::uint8_t>{1});
  Pose pose;
  pose.position = {-1, 8, 0};
  EXPECT_FALSE(world.add(voxel, pose).object);
  pose.position = {3, 8.25, 0};
  const int object = *world.add(voxel, pose).object;
  RigidMotion motion;
  motion.by = {-10, 0, 0};
  const MoveResult result = world.move(object, motion);
  EXPECT_NEAR(result.fraction, 0.35, 1e-6);
  EXPECT_EQ(result.contacts.at(0).other, no_voxel);
  EXPECT_NEAR(world.pose(object).position[0], -0.5, 1e-6);
  motion.by = {0.5, 0, 0};
  EXPECT_EQ(world.move(object, motion).fraction, 1);
  motion.by.setZero();
  motion.angle = pi / 4;
  motion.about = {2, 10.25, 0}; // its middle is at x = 2, a corner points to where the middles outside are
  EXPECT_LT(world.move(object, motion).fraction, 1);
}

// Analytic: an object that is moved and put back leaves the map as it was, cells between voxels too.
TEST(MatterContract, AnObjectTakesAllItsCellsAlong) {
  RigidWorld world({40, 40, 40}, {1, 1, 1});
  std::mt19937 random(4);
  Dice dice{random};
  const Pose pose = random_pose(dice, {20, 20, 20}, {9, 9, 9}, true);
  const int box = *world.add(RigidShape({3, 3, 3}, {3, 3, 3}, std::vector<std::uint8_t>(27, 1)), pose).object;
  const std::int64_t n = world.map().n_occupied();
  EXPECT_NEAR(double(n), 729, 80); // analytic: its volume, to the cells at its surface
  RigidMotion motion;
  motion.by = {1, 2, 3};
  ASSERT_EQ(world.move(box, motion).fraction, 1);
  motion.by = -motion.by;
  ASSERT_EQ(world.move(box, motion).fraction, 1);
  EXPECT_NEAR(double(world.map().n_occupied()), double(n), 2); // rounding of poses
}

} // namespace
} // namespace maille::deform
