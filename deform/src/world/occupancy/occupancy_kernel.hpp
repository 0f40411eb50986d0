#pragma once
/// Many cells of an occupancy map asked at a time.

#include "maille/scene/grid.hpp"

#include <cstdint>

namespace maille::deform {

/// The arrays of an OccupancyMap.
struct OccupancyTables {
  const std::int32_t* bricks; ///< for every place of a brick of 16^3 cells, which one it is; 0: empty
  const std::uint32_t* words; ///< 128 a brick: two rows of 16 cells along x each
  Index3 cells, n_bricks;
};

/// How many of n cells are taken or outside.
std::int64_t count_blocked(const OccupancyTables& tables, std::int64_t n, const std::int32_t* const cells[3]);

} // namespace maille::deform
