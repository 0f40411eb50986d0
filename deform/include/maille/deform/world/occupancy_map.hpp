#pragma once
/// Who is where in a world of cells.

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

/// One voxel's number a cell, and a bit beside it by which collisions are found without the numbers being
/// read.
///
/// Kept in bricks of 16^3 cells that exist only where something is: an empty world of 512^3 cells costs 128
/// KiB, a brick 16.9 KiB. Numbers of free cells are never written or read, so taking a voxel out costs its
/// bit alone.
///
/// Source  Gibson, Beyond volume rendering (1995), figure 1: a dense array of addresses, null where a cell is
///         free.
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
  /// Whether something cannot go there: taken, or outside the world, whose border is a wall.
  bool is_blocked(const Index3& at) const { return !has_cell(at) || is_occupied(at); }
  /// @pre has_cell(at) @return the empty id where the cell is free
  VoxelId occupant(const Index3& at) const;
  /// Whether any cell from `first` to `last` is taken; what lies outside the world is not asked. Costs a look
  /// at each brick of the box, and at each of its rows where there is a brick.
  bool is_any_occupied(const Index3& first, const Index3& last) const;

  /// The voxels numbered from `id` on, x fastest, into the cells of a box, each unless its cell is taken.
  /// @pre the cells are of this map
  void put_box(const Index3& first, const Index3& size, VoxelId id);
  /// @return whether its cell was free
  bool put(const Index3& at, VoxelId id);
  /// Frees the cells of a box, taken or not. @pre the cells are of this map
  void take_box(const Index3& first, const Index3& size);
  void take(const Index3& at);
  /// Whether any of n cells along x is taken or outside the world.
  bool is_row_blocked(const Index3& first, int n) const { return n_blocked_in_row(first, n) > 0; }
  /// How many of n cells along x are taken or outside the world.
  int n_blocked_in_row(const Index3& first, int n) const;
  /// How many of n cells are taken or outside the world, cells[axis][i] the i-th one's place along an axis;
  /// each as often as it is named.
  ///
  /// Cost        some 1 ns a cell: as many at a time as the machine's vectors have lanes, two gathers each
  /// Repeatable  the same for vectors of any length
  std::int64_t n_blocked(std::int64_t n, const std::int32_t* const cells[3]) const;

  std::int64_t n_occupied() const { return n_occupied_; }
  std::int64_t bytes() const;

private:
  static constexpr int brick_edge = 16;
  static constexpr std::int32_t empty =
      0; ///< the brick that stands wherever nothing is, and is never written
  /// A bit a cell, two rows along x a word: the even one's in its lower half, so that words can be gathered.
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
  std::vector<std::int32_t> bricks_; ///< for every place of a brick, which one it is
  std::vector<Mask> masks_;
  std::vector<std::unique_ptr<Ids>> ids_;
  std::vector<std::int32_t> counts_; ///< taken cells of a brick
  std::vector<std::int32_t> unused_; ///< bricks that nothing is in any more
  std::int64_t n_occupied_ = 0;
};

} // namespace maille::deform
