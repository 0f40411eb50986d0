#pragma once
/// Vectorised queries of an occupancy map, and writing of rows of a brick.

#include "maille/base/grid.hpp"

#include <cstdint>

namespace maille::deform {

/// A box of cells in one brick of 16^3, and the numbers of their voxels: x fastest, with constant steps
/// between rows and slabs.
struct BrickBox {
  int x, y, z;            ///< the first cell, each from 0 to 15
  int nx, ny, nz;         ///< size, at least 1; the box ends within the brick
  std::int32_t id;        ///< of the first cell
  std::int32_t row, slab; ///< steps of the number per row along y and per slab along z
};

/// Sets the bits of a box's cells and writes the numbers of those that were free; numbers of occupied cells
/// stay. @return count of new cells
///
/// @param words  the brick's 128, two rows of 16 bits each   @param ids  the brick's 16^3
/// Cost          one store per row of 16 with vectors that long, for whole and partial rows
/// Repeatable    the same for vectors of any length
std::int32_t put_in_brick(const BrickBox& box, std::uint32_t* words, std::int32_t* ids);
/// Clears the bits of a box's cells. @return count of bits that were set
std::int32_t take_from_brick(const BrickBox& box, std::uint32_t* words);

/// The arrays of an OccupancyMap.
struct OccupancyTables {
  const std::int32_t* bricks; ///< index of the brick of 16^3 cells at every place; 0: empty
  const std::uint32_t* words; ///< 128 a brick: two rows of 16 cells along x each
  Index3 cells, n_bricks;
};

/// Count of the n cells that are occupied or outside.
std::int64_t count_blocked(const OccupancyTables& tables, std::int64_t n, const std::int32_t* const cells[3]);

} // namespace maille::deform
