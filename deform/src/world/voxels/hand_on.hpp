#pragma once
/// The transfer of momentum of Gibson 1995, voxel by voxel.

#include "maille/deform/world/occupancy_map.hpp"

#include <Eigen/Core>

#include <span>
#include <vector>

namespace maille::deform {

/// One voxel of whatever object: a point that takes the cell it lies in.
struct FreeVoxel {
  Eigen::Vector3d place = Eigen::Vector3d::Zero(); ///< [cells]; in one and two dimensions the others are 1/2
  bool is_fixed = false;
};

/// One link of a chain of transfers.
struct VoxelMove {
  VoxelId voxel = 0;
  Eigen::Vector3d asked = Eigen::Vector3d::Zero(); ///< [cells]
  Eigen::Vector3d moved =
      Eigen::Vector3d::Zero(); ///< [cells]; what is left of `asked` was handed to the next in the list
};

struct Transfer {
  std::vector<VoxelMove> moves; ///< in order; the first is the voxel that was asked
  Eigen::Vector3d refused =
      Eigen::Vector3d::Zero();   ///< what a fixed voxel or the border did not take over [cells]
  VoxelId refused_by = no_voxel; ///< the empty id: the border, or no refusal
};

/// Moves a voxel along a straight line, cell by cell. Where the next cell is taken it goes as far as it can
/// within its own, and the rest of the movement goes to the voxel there, which goes on in the same way, until
/// the movement is used up, or a fixed voxel or the border is met: the sum of all that was moved and of what
/// was refused is what was asked.
///
/// Voxels stop node_skin (a billionth of a cell) before a face, so that no rounding puts two of them into one
/// cell; this is left to the next one, too.
///
/// @param map holds voxel i under the number i, one a cell, and is kept in step
/// Cost    the cells that are passed through
/// Source  Gibson, Beyond volume rendering (1995), "Object deformation"
/// Checked by tests/deform/world/world_test.cpp
Transfer hand_on(OccupancyMap& map, std::span<FreeVoxel> voxels, VoxelId voxel,
                 const Eigen::Vector3d& movement);

} // namespace maille::deform
