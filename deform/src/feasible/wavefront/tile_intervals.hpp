#pragma once
/// Bounds of links in whole numbers, by tile.

#include "feasible/wavefront/wavefront_kernel.hpp"
#include "feasible/wavefront/wavefront_tiling.hpp"
#include "lattice/field_memory.hpp"
#include "maille/scene/link_limits.hpp"

#include <cstdint>

namespace maille::deform {

/// Links of one displacement component, in quanta; a block is made for a tile at first use.
/// Bounds are rounded outward to whole quanta: low down, high up. So what is feasible stays feasible: if x_j
/// - x_i <= high in metres, floor(x_j / q) - floor(x_i / q) <= ceil(high / q), and the same with low;
/// rounding a state down to whole quanta, or from fine quanta to coarse ones, breaks no bound.
///
/// Tiles inside one kind of matter share one set of six numbers. The others, the surface and wherever kinds
/// meet, hold 27 bytes a node once they have been visited.
class TileIntervals {
public:
  /// @param component of the displacement; @param quantum [m]
  TileIntervals(const Tiling& tiling, const LinkLimits& limits, int component, double quantum);

  double quantum() const { return quantum_; }
  /// Changes the quantum and forgets all blocks.
  void set_quantum(double quantum);

  /// The block of a tile, or null where all its links are even(tile).
  const std::int32_t* block(std::int32_t tile) {
    const std::int32_t present = block_of_[tile];
    return present >= 0 ? blocks_[present].data() : present == unknown ? make_block(tile) : nullptr;
  }
  LinkIntervals<std::int32_t> even(std::int32_t tile) const {
    const auto kind = static_cast<std::size_t>(kind_of_[tile]);
    const auto& [low, high] = of_kind_;
    return {{low[0][kind], low[1][kind], low[2][kind]}, {high[0][kind], high[1][kind], high[2][kind]}};
  }
  /// The address of what block() would return, if it has been made: for prefetching.
  const std::int32_t* known_block(std::int32_t tile) const {
    const std::int32_t present = block_of_[tile];
    return present >= 0 ? blocks_[present].data() : nullptr;
  }
  BlockLayout layout() const { return {tiling_->volume()}; }
  /// About the mean length of a link, in quanta.
  std::int32_t mean_length() const { return mean_length_; }

private:
  static constexpr std::int32_t unknown = no_index, is_even = unknown - 1;

  const std::int32_t* make_block(std::int32_t tile);

  const Tiling* tiling_;
  const LinkLimits* limits_;
  int component_;
  double mean_slack_ = 0; ///< [m]
  FillBlock fill_block_;
  double quantum_ = 1;
  std::int32_t mean_length_ = 0;
  /// [axis][kind], kinds counted from 1; 0 is no matter, which binds nothing.
  LinkIntervals<List<std::int32_t>> of_kind_;
  List<std::int32_t> block_of_; ///< per tile
  List<std::int32_t> kind_of_;  ///< per tile, where it is even; from 1
  List<AlignedArray<std::int32_t>> blocks_;
};

/// An upper estimate of how far two nodes can part, for boxes and the like [m]: the sum over the grid's edges
/// of the largest slack along each axis.
double slack_across(const Grid& grid, const LinkLimits& limits, int component);

} // namespace maille::deform
