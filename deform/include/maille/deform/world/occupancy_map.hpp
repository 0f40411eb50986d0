#pragma once
/// Occupancy of the cells of a world.

#include "maille/base/grid.hpp"

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace maille::deform {

struct BrickBox;

/// The number of a voxel among all voxels of a world.
using VoxelId = std::int32_t;
inline constexpr VoxelId no_voxel = -1;

/// One voxel's number per cell, and a separate bit for collision tests without reading the numbers.
///
/// Stored in bricks of 16^3 cells, allocated only where cells are occupied: an empty world of 512^3 cells
/// takes 128 KiB, a brick 16.9 KiB. Numbers of free cells are never written or read, so that removing a voxel
/// only clears its bit.
///
/// Source  Gibson, Beyond volume rendering (1995), figure 1: a dense array of addresses, null for free cells.
class OccupancyMap {
public:
  /// @param cells per axis, > 0, at most 2^15 each; 1 along z for a world of two dimensions
  explicit OccupancyMap(const Index3& cells);
  OccupancyMap(const OccupancyMap& other);
  OccupancyMap& operator=(const OccupancyMap& other);
  OccupancyMap(OccupancyMap&&) noexcept = default;
  OccupancyMap& operator=(OccupancyMap&&) noexcept = default;
  ~OccupancyMap() = default;

  const Index3& cells() const { return cells_; }
  bool has_cell(const Index3& at) const {
    return is_below(at[0], cells_[0]) && is_below(at[1], cells_[1]) && is_below(at[2], cells_[2]);
  }
  /// @pre has_cell(at)
  bool is_occupied(const Index3& at) const {
    const auto brick = static_cast<std::size_t>(bricks_[brick_of(at)]);
    return ((masks_[brick][word_of(at)] >> ((at[0] & 15) + row_shift(at[1]))) & 1) != 0;
  }
  /// True if a cell is occupied or outside the world, whose border is a wall.
  bool is_blocked(const Index3& at) const { return !has_cell(at) || is_occupied(at); }
  /// @pre has_cell(at) @return no_voxel if the cell is free
  VoxelId occupant(const Index3& at) const;
  /// True if any cell from `first` to `last` is occupied; cells outside the world are ignored. Cost: a test
  /// of each brick of the box, and of each of its rows in allocated bricks.
  bool is_any_occupied(const Index3& first, const Index3& last) const;

  /// Puts voxels with numbers from `id` on, x fastest, into the cells of a box; occupied cells are skipped.
  /// @pre the cells are of this map
  void put_box(const Index3& first, const Index3& size, VoxelId id);
  /// @return true if the cell was free
  bool put(const Index3& at, VoxelId id);
  /// Frees the cells of a box, occupied or not. @pre the cells are of this map
  void take_box(const Index3& first, const Index3& size);
  void take(const Index3& at);
  /// True if any of n cells along x is occupied or outside the world.
  bool is_row_blocked(const Index3& first, int n) const { return n_blocked_in_row(first, n) > 0; }
  /// Number of n cells along x that are occupied or outside the world.
  int n_blocked_in_row(const Index3& first, int n) const;
  /// Number of n cells that are occupied or outside the world; cells[axis][i] is the i-th one's coordinate
  /// along an axis. Repeated cells count repeatedly.
  ///
  /// Cost        about 1 ns a cell: vectorised, with two gathers per vector
  /// Repeatable  the same for vectors of any length
  std::int64_t n_blocked(std::int64_t n, const std::int32_t* const cells[3]) const;

  std::int64_t n_occupied() const { return n_occupied_; }
  std::int64_t bytes() const;

private:
  static constexpr int brick_edge = 16;
  static constexpr std::int32_t empty = 0; ///< the shared empty brick, never written
  /// A bit per cell, two rows along x per word, the even one in the lower half, so that words can be
  /// gathered.
  using Mask = std::array<std::uint32_t, brick_edge * brick_edge / 2>;
  struct alignas(64) Ids { ///< a row along x is a cache line
    std::array<VoxelId, brick_edge * brick_edge * brick_edge> of;
  };

  static bool is_below(int i, int n) { return static_cast<unsigned>(i) < static_cast<unsigned>(n); }
  std::size_t brick_of(const Index3& at) const {
    return static_cast<std::size_t>(
        (at[0] >> 4) + n_bricks_[0] * ((at[1] >> 4) + std::int64_t{n_bricks_[1]} * (at[2] >> 4)));
  }
  static std::size_t row_of(const Index3& at) {
    return static_cast<std::size_t>((at[1] & 15) + brick_edge * (at[2] & 15));
  }
  static std::size_t word_of(const Index3& at) {
    return static_cast<std::size_t>(((at[1] & 15) >> 1) + brick_edge / 2 * (at[2] & 15));
  }
  static int row_shift(int y) { return brick_edge * (y & 1); }
  /// Calls visit(first cell, box in its brick) for the parts of a box in each brick.
  template<class Visit>
  static void for_each_part(const Index3& first, const Index3& size, VoxelId id, Visit&& visit);
  void put_part(const Index3& first, const BrickBox& box);
  void take_part(const Index3& first, const BrickBox& box);
  std::int32_t new_brick(std::size_t at);
  void release(std::size_t at);

  Index3 cells_, n_bricks_;
  std::vector<std::int32_t> bricks_; ///< index of the brick at every place
  std::vector<Mask> masks_;
  std::vector<std::unique_ptr<Ids>> ids_;
  std::vector<std::int32_t> counts_; ///< occupied cells of a brick
  std::vector<std::int32_t> unused_; ///< bricks without occupied cells, for reuse
  std::int64_t n_occupied_ = 0;
};

} // namespace maille::deform
