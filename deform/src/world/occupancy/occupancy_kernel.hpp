#pragma once
/// Many cells of an occupancy map asked at a time, and rows of a brick written at a time.

#include "maille/base/grid.hpp"

#include <cstdint>

namespace maille::deform {

/// Cells of one brick of 16^3, and the numbers of the voxels that want them: x fastest, each row and slab
/// further on by a fixed step.
struct BrickBox {
  int x, y, z;            ///< the first cell, each from 0 to 15
  int nx, ny, nz;         ///< how many cells, at least 1, none beyond 15
  std::int32_t id;        ///< of the first cell
  std::int32_t row, slab; ///< from one row to the next along y, and from one slab to the next along z
};

/// Sets the bits of a box's cells and writes the numbers of those that were free, whose others stay as they
/// are. @return how many
///
/// @param words  128 of the brick's, two rows of 16 bits each   @param ids  16^3 of the brick's
/// Cost          a store a row of 16 where vectors are as long; rows are written whole or in part alike
/// Repeatable    the same for vectors of any length
std::int32_t put_in_brick(const BrickBox& box, std::uint32_t* words, std::int32_t* ids);
/// Clears the bits of a box's cells. @return how many were set
std::int32_t take_from_brick(const BrickBox& box, std::uint32_t* words);

/// The arrays of an OccupancyMap.
struct OccupancyTables {
  const std::int32_t* bricks; ///< for every place of a brick of 16^3 cells, which one it is; 0: empty
  const std::uint32_t* words; ///< 128 a brick: two rows of 16 cells along x each
  Index3 cells, n_bricks;
};

/// How many of n cells are taken or outside.
std::int64_t count_blocked(const OccupancyTables& tables, std::int64_t n, const std::int32_t* const cells[3]);

} // namespace maille::deform
