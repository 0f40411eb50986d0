#pragma once
/// Fields that are known at some voxels, continued to all others. Private to scene.

#include "maille/scene/grid.hpp"

#include <cstdint>
#include <vector>

namespace maille::warping {

/// For every voxel the known one that fewest steps along the axes lead to (itself, where it is known), of
/// equals one that depends on nothing but where they are; -1 everywhere where none is known.
/// Cost  O(voxels): two passes along each axis; 8 bytes a voxel
std::vector<std::int32_t> nearest_known(const Index3& size, const std::vector<bool>& is_known);

} // namespace maille::warping
