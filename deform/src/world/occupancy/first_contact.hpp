#pragma once
/// First contact of a moving object.

#include "maille/deform/world/occupancy_map.hpp"
#include "maille/deform/world/rigid_world.hpp"

#include <vector>

namespace maille::deform {

/// The first voxel of the shape whose middle enters a blocked cell on the way, exactly: every cell that any
/// voxel passes through is tested, up to the earliest contact found so far. Of simultaneous contacts, the
/// voxel with the smallest number is returned.
///
/// The map must not contain the shape itself. If no blocked cell is near the bounding box of the whole
/// motion, no voxel is tested. Blocks of voxels without blocked cells near their ball are skipped. If the
/// lattice equals the world's and the motion is a shift, only voxels open towards a direction of the shift
/// are tested: any other voxel enters only cells that its neighbour was in at that time.
///
/// Cost  O(voxels tested * cells passed); no allocation
std::optional<Contact> first_contact(const OccupancyMap& map, const Vec3& cell_size, const RigidShape& shape,
                                     const Pose& pose, const RigidMotion& motion);

/// A blocked cell that a voxel enters on the way.
struct Entry {
  double time = 0;
  std::int32_t voxel = 0;
  Index3 cell{};
  int axis = 0, direction = 1; ///< of the face of entry
};

/// All entries, voxel by voxel, without obstacles; then cells whose middles enter voxels. The shape's own
/// cells are omitted.
/// @param first the number of the shape's voxel 0 in the map
std::vector<Entry> entries_on_the_way(const OccupancyMap& map, const Vec3& cell_size, const RigidShape& shape,
                                      VoxelId first, const Pose& pose, const RigidMotion& motion);

/// Moves a shape's pose along a motion, up to a billionth of a cell before the first contact: of a voxel's
/// middle with a blocked cell or, if rotated voxels are longer than cells, of a voxel's box with the middle
/// of a blocked cell (see posed_matter.hpp).
///
/// @param[in,out] pose start, then pose after `done` of the motion; both in no blocked cell
/// @return the contact; nothing if the whole motion was free
std::optional<Contact> move_until_contact(const OccupancyMap& map, const Vec3& cell_size,
                                          const RigidShape& shape, const RigidMotion& motion, Pose& pose,
                                          double& done);

/// @throws std::invalid_argument if a motion is not finite, turns by more than half a circle, or has no axis
void check(const RigidMotion& motion);

/// True if any voxel's middle is in a blocked cell, or any voxel contains the middle of an occupied one.
bool is_blocked(const OccupancyMap& map, const Vec3& cell_size, const RigidShape& shape, const Pose& pose);

} // namespace maille::deform
