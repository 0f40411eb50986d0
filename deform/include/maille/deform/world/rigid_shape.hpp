#pragma once
/// The voxels of a rigid object.

#include "maille/base/grid.hpp"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace maille::deform {

/// Voxels on the object's own lattice; motions never resample them.
///
/// A voxel is the point at its centre: index + 1/2, times the spacing, in the object's frame [m]. It occupies
/// the cell of the world that contains this point.
class RigidShape {
public:
  /// @param size of the lattice, at most 2^15 per axis @param spacing > 0 [m]
  /// @param matter size[0] * size[1] * size[2] values, x fastest, nonzero for voxels
  /// @throws std::invalid_argument without voxels, or if sizes do not match
  RigidShape(const Index3& size, const Vec3& spacing, std::span<const std::uint8_t> matter);

  /// A run of voxels along x.
  struct Row {
    std::array<std::int16_t, 3> first;
    std::int16_t n;
    std::int32_t voxel; ///< number of the first
  };
  /// Voxels that are close in space, with consecutive numbers.
  struct Block {
    std::int32_t first, end;
    Vec3 centre;                     ///< of a bounding ball of the voxels' centres, in the object's frame [m]
    double radius;                   ///< [m]
    Index3 low, size;                ///< bounding box of the indices
    std::int32_t first_row, end_row; ///< among rows()
    /// True if every place of the box has a voxel; numbers are then consecutive along x, then y, then z.
    bool is_full() const { return end - first == size[0] * size[1] * size[2]; }
  };

  const Index3& size() const { return size_; }
  const Vec3& spacing() const { return spacing_; }
  std::int32_t n_voxels() const { return static_cast<std::int32_t>(index_[0].size()); }
  /// Lattice indices of voxels along an axis.
  std::span<const std::int16_t> index(int axis) const { return index_[axis]; }
  Index3 index_of(std::int32_t voxel) const;
  /// In the object's frame [m].
  Eigen::Vector3d centre_of(std::int32_t voxel) const;
  /// The middle of the lattice, in the object's frame [m].
  Eigen::Vector3d middle() const;
  std::span<const Row> rows() const { return rows_; }
  std::span<const Block> blocks() const { return blocks_; }
  /// Bit 2 a + (1 for the upper side) is set if a voxel has no neighbour along axis a on that side.
  std::uint8_t open_sides(std::int32_t voxel) const { return open_[voxel]; }
  std::int64_t bytes() const;

private:
  void add_block(const Index3& begin, std::span<const std::uint8_t> matter);

  Index3 size_;
  Vec3 spacing_;
  std::array<std::vector<std::int16_t>, 3> index_;
  std::vector<Row> rows_;
  std::vector<Block> blocks_;
  std::vector<std::uint8_t> open_;
};

/// Pose of an object: x = position + rotation X, X in its own frame.
struct Pose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d position = Eigen::Vector3d::Zero(); ///< [m]
};

/// A rotation about an axis through `about`, and a shift, both uniform over a time from 0 to 1:
/// x(t) = about + R(t angle) (x - about) + t by.
struct RigidMotion {
  Eigen::Vector3d by = Eigen::Vector3d::Zero();    ///< [m]
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ(); ///< of length 1
  double angle = 0;                                ///< right-handed about the axis [rad], from -pi to pi
  Eigen::Vector3d about = Eigen::Vector3d::Zero(); ///< [m]

  /// The pose at time t; bit-identical to `from` at t = 0. Without a turn, the rotation is too.
  Pose moved(const Pose& from, double t) const;
};

/// Distance of a point from the furthest corner of a shape's lattice at a pose [m].
double furthest_corner(const RigidShape& shape, const Pose& pose, const Eigen::Vector3d& from);

} // namespace maille::deform
