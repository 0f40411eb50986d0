#pragma once
/// Positions of the nodes of a deformable object in a world of cells.

#include "maille/deform/world/rigid_shape.hpp"
#include "maille/scene/answer.hpp"
#include "world/occupancy/cell_walk.hpp"

#include <Eigen/Core>

#include <cstdint>
#include <span>
#include <vector>

namespace maille::deform {

/// Clamp for cell coordinates: far outside any world, within the range of int.
inline constexpr double furthest_cell = 1 << 30;

/// A place in the world, in cells along each axis; 1/2 along axes beyond the world's dimension.
using InCells = std::array<double, 3>;

/// The nodes of a body, numbered from 0 in the order of its grid ("voxels" of the world), at a fixed pose.
class PosedLattice {
public:
  PosedLattice(const Specimen& specimen, const Pose& pose, const Vec3& cell_size);

  std::int32_t n_voxels() const { return static_cast<std::int32_t>(nodes_.size()); }
  std::int64_t node(std::int32_t voxel) const { return nodes_[voxel]; }
  /// @return -1 if the grid's node is not a node of the body
  std::int32_t voxel(std::int64_t node) const { return voxels_[node]; }

  /// True if the object's axes differ from the world's.
  bool is_turned() const { return is_turned_; }
  int dimension() const { return dimension_; }
  InCells place(std::int32_t voxel, const Displacement& displacement) const;
  /// Places of all voxels.
  std::vector<InCells> places(const Displacement& displacement) const;
  Eigen::Vector3d position(std::int32_t voxel, const Displacement& displacement) const;
  Eigen::Vector3d rest(std::int32_t voxel) const { return rest_[voxel]; }
  /// Displacement in the object's frame that changes a place along one axis of the world to `to` [cells].
  Vec3 moved_along(std::int32_t voxel, const Displacement& displacement, int axis, double to) const;
  /// Displacement in the object's frame that moves a node to a position in the world.
  Vec3 displacement_at(std::int32_t voxel, const Eigen::Vector3d& position) const;
  const Pose& pose() const { return pose_; }
  const Vec3& cell_size() const { return cell_size_; }
  std::int64_t bytes() const;

private:
  Pose pose_;
  Vec3 cell_size_;
  int dimension_;
  bool is_turned_;
  std::vector<std::int64_t> nodes_;
  std::vector<std::int32_t> voxels_;
  std::vector<Eigen::Vector3d> rest_; ///< in the world [m]
};

/// The cell of a place.
Index3 cell_at(const InCells& place);

} // namespace maille::deform
