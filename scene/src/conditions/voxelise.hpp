#pragma once
/// Closed surfaces of triangles as voxels of labels.

#include "conditions/places_in_files.hpp"

namespace maille::reader {

/// Voxels whose middles are inside of a surface: 1 of the first, 2 of the second, and so on; of several
/// that hold the same middle the last one. The grid is the surfaces' box, of whole voxels from its least
/// corner on.
///
/// Inside is where a line along x has entered more closed shells of a surface than it has left, by the
/// order of their triangles' corners: shells that overlap are one, a shell of the other orientation is a
/// hollow. Where triangles are not oriented alike, it is where the line has crossed an odd number of
/// times. It is led a millionth of a voxel past the middles, so that it meets no edge of a mesh that is
/// made on a grid.
/// @param surfaces in metres, in one frame @param spacing of voxels along each axis [m]
/// @param lost  gets a sentence for each surface with shells (or hollows) that hold no voxel's middle
/// A fault where a surface is not closed: somewhere a line enters it and does not leave.
/// Cost  O(triangles x rows that they cover + voxels)
OrFault<Image> voxelised(const std::vector<std::vector<Triangle>>& surfaces, const Vec3& spacing,
                         std::vector<std::string>* lost = nullptr);

/// The voxels along each axis that voxelised() would make; larger than any where they cannot be counted.
std::array<double, 3> voxels_of(const std::vector<std::vector<Triangle>>& surfaces, const Vec3& spacing);

} // namespace maille::reader
