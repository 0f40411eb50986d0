#pragma once
/// Converts closed triangulated surfaces to voxels of labels.

#include "conditions/places_in_files.hpp"

namespace maille::reader {

/// Voxels whose centres are inside a surface: 1 for the first, 2 for the second, and so on; the last one
/// applies if several contain a centre. The grid is the surfaces' bounding box, in whole voxels from its
/// lower corner.
///
/// A point is inside if a line along x has entered more closed shells of a surface than it has left, by the
/// orientation of their triangles: overlapping shells merge, a shell of opposite orientation is a cavity. If
/// triangles are not oriented consistently, a point is inside after an odd number of crossings. Lines pass a
/// millionth of a voxel beside the centres, so that they meet no edge of a mesh that was made on a grid.
/// @param surfaces in metres, in one frame @param spacing of voxels along each axis [m]
/// @param lost  receives a sentence for each surface with shells (or cavities) that contain no voxel centre
/// A fault if a surface is not closed: some line enters it and does not leave.
/// Cost  O(triangles x rows that they cover + voxels)
OrFault<Image> voxelised(const std::vector<std::vector<Triangle>>& surfaces, const Vec3& spacing,
                         std::vector<std::string>* lost = nullptr);

/// Number of voxels along each axis of voxelised(); may exceed the range of integers.
std::array<double, 3> voxels_of(const std::vector<std::vector<Triangle>>& surfaces, const Vec3& spacing);

} // namespace maille::reader
