#pragma once
/// When a moving object first meets something.

#include "maille/deform/world/occupancy_map.hpp"
#include "maille/deform/world/rigid_world.hpp"

namespace maille::deform {

/// The first voxel of the shape that enters a blocked cell on the way, exactly: every cell that any voxel passes through is asked, up to the
/// earliest contact found so far. Of voxels that meet something at the same time, the one with the smallest number.
///
/// The map must not hold the shape itself. Blocks of voxels whose ball meets nothing on the way are passed over; a shape whose lattice is
/// the world's and that only shifts asks voxels alone that are open towards a direction of the shift: any other voxel enters only
/// cells that its own neighbour was in at that time.
///
/// Cost  O(voxels asked * cells passed); nothing is allocated
std::optional<Contact> first_contact(const OccupancyMap& map, const Vec3& cell_size, const RigidShape& shape,
                                     const Pose& pose, const RigidMotion& motion);

/// The same for all voxels and all cells: the oracle of the above.
std::optional<Contact> first_contact_of_every_voxel(const OccupancyMap& map, const Vec3& cell_size,
                                                    const RigidShape& shape, const Pose& pose,
                                                    const RigidMotion& motion);

/// Whether any voxel is in a blocked cell.
bool is_blocked(const OccupancyMap& map, const Vec3& cell_size, const RigidShape& shape, const Pose& pose);

} // namespace maille::deform
