#pragma once
/// When a moving object first meets something.

#include "maille/deform/world/occupancy_map.hpp"
#include "maille/deform/world/rigid_world.hpp"

#include <vector>

namespace maille::deform {

/// The first voxel of the shape whose middle enters a blocked cell on the way, exactly: every cell that any
/// voxel passes through is asked, up to the earliest contact found so far. Of voxels that meet something at
/// the same time, the one with the smallest number.
///
/// The map must not hold the shape itself. Where nothing is near the box that the whole shape passes through,
/// no voxel is asked. Blocks of voxels whose ball meets nothing on the way are passed over; a shape whose
/// lattice is the world's and that only shifts asks voxels alone that are open towards a direction of the
/// shift: any other voxel enters only cells that its own neighbour was in at that time.
///
/// Cost  O(voxels asked * cells passed); nothing is allocated
std::optional<Contact> first_contact(const OccupancyMap& map, const Vec3& cell_size, const RigidShape& shape,
                                     const Pose& pose, const RigidMotion& motion);

/// The same for all voxels and all cells: the oracle of the above.
std::optional<Contact> first_contact_of_every_voxel(const OccupancyMap& map, const Vec3& cell_size,
                                                    const RigidShape& shape, const Pose& pose,
                                                    const RigidMotion& motion);

/// A blocked cell that a voxel enters on the way.
struct Entry {
  double time = 0;
  std::int32_t voxel = 0;
  Index3 cell{};
  int axis = 0, direction = 1; ///< of the face that it is entered through
};

/// All of them, voxel by voxel, as if nothing were in the way, then those whose middles voxels come over;
/// those that the map says are the shape's own are left out.
/// @param first the number of the shape's voxel 0 in the map
std::vector<Entry> entries_on_the_way(const OccupancyMap& map, const Vec3& cell_size, const RigidShape& shape,
                                      VoxelId first, const Pose& pose, const RigidMotion& motion);

/// Moves a shape's pose along a motion, up to a billionth of a cell before the first contact: of a voxel's
/// middle with a blocked cell, or, where voxels are longer than cells as they stand, of a voxel's box with
/// the middle of one (see posed_matter.hpp).
///
/// @param pose where it is, in no blocked cell; then where it is after `done` of the motion, in no blocked
///        cell
/// @return the contact that stopped it; nothing where the whole motion was free
std::optional<Contact> move_until_contact(const OccupancyMap& map, const Vec3& cell_size,
                                          const RigidShape& shape, const RigidMotion& motion, Pose& pose,
                                          double& done);

/// @throws std::invalid_argument if a motion is not finite, turns by more than half a circle, or has no axis
void check(const RigidMotion& motion);

/// Whether any voxel's middle is in a blocked cell, or any voxel holds the middle of a taken one.
bool is_blocked(const OccupancyMap& map, const Vec3& cell_size, const RigidShape& shape, const Pose& pose);

} // namespace maille::deform
