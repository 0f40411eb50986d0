#pragma once
/// One displacement component of a body in tiles, as whole numbers of quanta.

#include "feasible/wavefront/tile_intervals.hpp"
#include "feasible/wavefront/wavefront_queue.hpp"

#include "maille/base/arena.hpp"

#include <cstdint>
#include <span>

namespace maille::deform {

/// A node with a lower (raise) or upper (lower) bound on its value, in quanta.
struct Seed {
  TilePlace place;
  std::int64_t value = 0;
};

/// Values of all nodes of a body: x = (offset + stored) quanta, stored in 32 bits. Slots that are no nodes
/// hold something in range that nothing depends on.
///
/// run() reaches the one least (greatest) fixpoint: sums of whole numbers are exact, and no link
/// adds anything on the way (low <= 0 <= high), so a value is the best of its own start and of all sums along
/// paths, whatever the order. It ends: every change is one quantum or more, one way, and bounded by the
/// seeds.
class TileField {
public:
  explicit TileField(const Tiling& tiling);

  // Values.
  std::int64_t offset() const { return offset_; }
  std::int64_t value(const TilePlace& place) const { return offset_ + values_[at(place)]; }
  /// The same value everywhere. @pre value is within largest_value of offset
  void fill(std::int64_t value, std::int64_t offset);
  /// True if values from `low` to `high` can be stored.
  bool spans(std::int64_t low, std::int64_t high) const {
    return low >= offset_ - largest_value && high <= offset_ + largest_value;
  }
  /// Values of the nodes of one tile, for reading and writing: [slot].
  std::int32_t* tile(std::int32_t tile) {
    return values_.data() + std::int64_t{1} * tile * tiling_->volume();
  }
  const std::int32_t* tile(std::int32_t tile) const {
    return values_.data() + std::int64_t{1} * tile * tiling_->volume();
  }
  /// Smallest and largest value of any node.
  std::pair<std::int64_t, std::int64_t> range() const;
  /// True if any node has the smallest or largest value that can be stored.
  bool touches_its_range() const;
  /// Moves the window of values: stored values are cut to what can be stored around `offset`.
  void set_offset(std::int64_t offset);
  /// Divides all values by 2^bits, rounding down.
  void coarsen(int bits);

  // Propagation.
  /// Raises (lowers) values to the seeds', and all others as far as links require. @pre the state is
  /// feasible, and the field spans the seeds' values
  void run(Way way, TileIntervals& bounds, std::span<const Seed> seeds);
  /// Makes every link feasible, from any state: the least feasible state above it, or the greatest below.
  void run_everywhere(Way way, TileIntervals& bounds);

  // Taking back.
  /// Starts to record tiles before run() changes them.
  void begin();
  /// Back to the state at begin(). @pre no other change since
  void undo_run();
  void keep() { is_recording_ = false; }
  /// A copy of everything, for changes of the window.
  struct Copy {
    std::int64_t offset = 0;
    bool is_even = true;
    List<std::int32_t> values; ///< one where is_even
  };
  void copy_to(Copy& copy) const;
  void restore(const Copy& copy);

  // Bookkeeping.
  std::int64_t n_visits() const { return n_visits_; }

private:
  std::size_t at(const TilePlace& place) const {
    return static_cast<std::size_t>(place.tile) * static_cast<std::size_t>(tiling_->volume()) +
           static_cast<std::size_t>(place.slot);
  }
  void work_off(Way way, TileIntervals& bounds);
  void touch(std::int32_t tile);
  void record(std::int32_t tile);
  void prefetch(const TileIntervals& bounds, std::int32_t tile) const;

  const Tiling* tiling_;
  VisitTile visit_tile_;
  std::int64_t offset_ = 0;
  AlignedArray<std::int32_t> values_; ///< [tile][slot]
  TileQueue queue_;
  bool is_even_ = true; ///< nothing has changed since fill()

  bool is_recording_ = false, was_even_ = false;
  std::int32_t even_value_ = 0; ///< as stored, where is_even_ or was_even_
  List<std::int32_t> recorded_; ///< tiles
  List<bool> is_recorded_;
  List<std::int32_t> record_; ///< their values at begin(), unless was_even_
  std::int64_t n_visits_ = 0;
};

} // namespace maille::deform
