#pragma once
/// Fields that are known at some voxels, continued to all others. Private to scene.

#include "maille/base/grid.hpp"

#include <cstdint>
#include <vector>

namespace maille::warping {

/// For every voxel the known one that fewest steps along the axes lead to (itself, where it is known), of
/// equals one that depends on nothing but where they are; -1 everywhere where none is known.
/// @param known of every voxel its own number, or -1 where it is not known
/// Cost  O(voxels): two passes along each axis; 2 bytes a voxel besides what is given (4 where the sizes of
///       the image add up to 16,383 and more)
std::vector<std::int32_t> nearest_known(const Index3& size, std::vector<std::int32_t> known);

} // namespace maille::warping
