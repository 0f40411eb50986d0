#pragma once
/// Extends fields that are known at some voxels to all others. Private to scene.

#include "maille/base/grid.hpp"

#include <cstdint>
#include <vector>

namespace maille::warping {

/// For every voxel: the known voxel with the fewest steps along the axes (itself, if it is known); among
/// equals the choice depends only on positions; -1 if none is known.
/// @param known per voxel: its own number, or -1 if it is unknown
/// Cost  O(voxels): two passes along each axis; 2 bytes per voxel besides the arguments (4 if the sizes of
///       the image sum to 16,383 or more)
std::vector<std::int32_t> nearest_known(const Index3& size, std::vector<std::int32_t> known);

} // namespace maille::warping
