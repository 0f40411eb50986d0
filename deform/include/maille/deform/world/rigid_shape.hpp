#pragma once
/// The voxels of an object that keeps its form.

#include "maille/base/grid.hpp"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace maille::deform {

/// Voxels on a lattice of the object's own, which no movement ever resamples.
///
/// A voxel is the point at its centre: index + 1/2, times the spacing, in the object's frame [m]. It takes
/// the one cell of the world that this point lies in.
class RigidShape {
public:
  /// @param size of the lattice, at most 2^15 an axis @param spacing > 0 [m]
  /// @param matter size[0] * size[1] * size[2] values, x fastest, not 0 where there is a voxel
  /// @throws std::invalid_argument if there is no voxel, or sizes do not match
  RigidShape(const Index3& size, const Vec3& spacing, std::span<const std::uint8_t> matter);

  /// Voxels that follow one another along x.
  struct Row {
    std::array<std::int16_t, 3> first;
    std::int16_t n;
    std::int32_t voxel; ///< number of the first
  };
  /// Voxels near one another, one after another in number.
  struct Block {
    std::int32_t first, end;
    Vec3 centre;                     ///< of a ball about the voxels' centres, in the object's frame [m]
    double radius;                   ///< [m]
    Index3 low, size;                ///< the box of indices about them
    std::int32_t first_row, end_row; ///< among rows()
    /// Whether every place of the box has a voxel; their numbers then go on along x, then y, then z.
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
  /// Bit 2 a + (1 if upwards) is set where a voxel has no voxel of its own beside it along axis a.
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

/// Where an object is: x = position + rotation X, X in its own frame.
struct Pose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d position = Eigen::Vector3d::Zero(); ///< [m]
};

/// A turn about an axis through `about`, and a shift, both done evenly over a time from 0 to 1:
/// x(t) = about + R(t angle) (x - about) + t by.
struct RigidMotion {
  Eigen::Vector3d by = Eigen::Vector3d::Zero();    ///< [m]
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ(); ///< of length 1
  double angle = 0; ///< right-handed about the axis [rad], at most pi either way
  Eigen::Vector3d about = Eigen::Vector3d::Zero(); ///< [m]

  /// The pose at time t; t = 0 gives `from` itself, to the bit. Without a turn the rotation stays to the bit.
  Pose moved(const Pose& from, double t) const;
};

/// Distance of a point from the furthest corner of a shape's lattice at a pose [m].
double furthest_corner(const RigidShape& shape, const Pose& pose, const Eigen::Vector3d& from);

} // namespace maille::deform
