#include "maille/deform/world/occupancy_map.hpp"

#include "world/occupancy/occupancy_kernel.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <memory>
#include <stdexcept>

namespace maille::deform {

namespace {

constexpr int most_cells = 1 << 15;

/// Bits of a row from cell `first` to cell `last` of a brick.
std::uint32_t bits_between(int first, int last) {
  return (0xFFFFu >> (15 - last)) & (0xFFFFu << first);
}

/// Compares component by component: comparing the whole array stalls on values just written.
bool is_one_cell(const Index3& size) {
  return size[0] == 1 && size[1] == 1 && size[2] == 1;
}

} // namespace

OccupancyMap::OccupancyMap(const OccupancyMap& other)
    : cells_(other.cells_), n_bricks_(other.n_bricks_), bricks_(other.bricks_), masks_(other.masks_),
      counts_(other.counts_), unused_(other.unused_), n_occupied_(other.n_occupied_) {
  for (const auto& ids : other.ids_)
    ids_.push_back(ids ? std::make_unique<Ids>(*ids) : nullptr);
}

OccupancyMap& OccupancyMap::operator=(const OccupancyMap& other) {
  if (this != &other)
    *this = OccupancyMap(other);
  return *this;
}

OccupancyMap::OccupancyMap(const Index3& cells) : cells_(cells) {
  for (std::size_t a = 0; a < 3; ++a) {
    if (cells[a] < 1 || cells[a] > most_cells)
      throw std::invalid_argument("OccupancyMap: 1 to 32768 cells along every axis");
    n_bricks_[a] = (cells[a] + brick_edge - 1) / brick_edge;
  }
  bricks_.assign(std::int64_t{1} * n_bricks_[0] * n_bricks_[1] * n_bricks_[2], empty);
  masks_.emplace_back();
  ids_.emplace_back();
  counts_.push_back(0);
}

VoxelId OccupancyMap::occupant(const Index3& at) const {
  if (!is_occupied(at))
    return no_voxel;
  const auto brick = static_cast<std::size_t>(bricks_[brick_of(at)]);
  return ids_[brick]->of[row_of(at) * brick_edge + static_cast<std::size_t>(at[0] & 15)];
}

bool OccupancyMap::is_any_occupied(const Index3& first, const Index3& last) const {
  Index3 low, high;
  for (std::size_t a = 0; a < 3; ++a) {
    low[a] = std::max(first[a], 0);
    high[a] = std::min(last[a], cells_[a] - 1);
    if (low[a] > high[a])
      return false;
  }
  for (int bz = low[2] >> 4; bz <= high[2] >> 4; ++bz)
    for (int by = low[1] >> 4; by <= high[1] >> 4; ++by)
      for (int bx = low[0] >> 4; bx <= high[0] >> 4; ++bx) {
        const std::int32_t brick = bricks_[brick_of({16 * bx, 16 * by, 16 * bz})];
        if (brick == empty)
          continue;
        const Mask& mask = masks_[brick];
        const std::uint32_t wanted =
            bits_between(std::max(low[0] - 16 * bx, 0), std::min(high[0] - 16 * bx, 15));
        for (int z = std::max(low[2], 16 * bz); z <= std::min(high[2], 16 * bz + 15); ++z)
          for (int y = std::max(low[1], 16 * by); y <= std::min(high[1], 16 * by + 15); ++y)
            if ((mask[word_of({0, y, z})] & (wanted << row_shift(y))) != 0)
              return true;
      }
  return false;
}

int OccupancyMap::n_blocked_in_row(const Index3& first, int n) const {
  if (!is_below(first[1], cells_[1]) || !is_below(first[2], cells_[2]))
    return n;
  const int begin = std::max(first[0], 0), end = std::min(first[0] + n, cells_[0]);
  if (begin >= end)
    return n;
  int blocked = n - (end - begin);
  for (int x = begin; x < end; x = (x | 15) + 1) {
    const Index3 at{x, first[1], first[2]};
    const auto brick = static_cast<std::size_t>(bricks_[brick_of(at)]);
    const std::uint32_t wanted = bits_between(x & 15, std::min(end - 1, x | 15) & 15);
    blocked += std::popcount(masks_[brick][word_of(at)] & (wanted << row_shift(at[1])));
  }
  return blocked;
}

std::int64_t OccupancyMap::n_blocked(std::int64_t n, const std::int32_t* const cells[3]) const {
  constexpr std::size_t most_gathered = std::size_t{1} << 24; // word indices then fit into 31 bits
  if (bricks_.size() < most_gathered && masks_.size() < most_gathered)
    return count_blocked({bricks_.data(), masks_.front().data(), cells_, n_bricks_}, n, cells);
  std::int64_t blocked = 0;
  for (std::int64_t i = 0; i < n; ++i)
    blocked += is_blocked({cells[0][i], cells[1][i], cells[2][i]});
  return blocked;
}

std::int32_t OccupancyMap::new_brick(std::size_t at) {
  if (unused_.empty()) {
    unused_.push_back(static_cast<std::int32_t>(masks_.size()));
    masks_.emplace_back();
    ids_.push_back(std::make_unique_for_overwrite<Ids>());
    counts_.push_back(0);
  }
  bricks_[at] = unused_.back();
  unused_.pop_back();
  return bricks_[at];
}

void OccupancyMap::release(std::size_t at) {
  unused_.push_back(bricks_[at]); // its mask is empty
  bricks_[at] = empty;
}

template<class Visit>
void OccupancyMap::for_each_part(const Index3& first, const Index3& size, VoxelId id, Visit&& visit) {
  const Index3 end{first[0] + size[0], first[1] + size[1], first[2] + size[2]};
  const std::int32_t row = size[0], slab = size[0] * size[1];
  const auto next = [](int i) { return (i | 15) + 1; }; // brick
  for (int z = first[2]; z < end[2]; z = next(z))
    for (int y = first[1]; y < end[1]; y = next(y))
      for (int x = first[0]; x < end[0]; x = next(x))
        visit(Index3{x, y, z},
              BrickBox{x & 15, y & 15, z & 15, std::min(next(x), end[0]) - x, std::min(next(y), end[1]) - y,
                       std::min(next(z), end[2]) - z,
                       id + (x - first[0]) + row * (y - first[1]) + slab * (z - first[2]), row, slab});
}

bool OccupancyMap::put(const Index3& at, VoxelId id) {
  const std::size_t place = brick_of(at);
  const auto brick = static_cast<std::size_t>(bricks_[place] != empty ? bricks_[place] : new_brick(place));
  std::uint32_t& word = masks_[brick][word_of(at)];
  const std::uint32_t bit = std::uint32_t{1} << ((at[0] & 15) + row_shift(at[1]));
  if ((word & bit) != 0)
    return false;
  word |= bit;
  ids_[brick]->of[row_of(at) * brick_edge + static_cast<std::size_t>(at[0] & 15)] = id;
  ++counts_[brick];
  ++n_occupied_;
  return true;
}

void OccupancyMap::take(const Index3& at) {
  const std::size_t place = brick_of(at);
  const auto brick = static_cast<std::size_t>(bricks_[place]);
  std::uint32_t& word = masks_[brick][word_of(at)];
  const std::uint32_t bit = std::uint32_t{1} << ((at[0] & 15) + row_shift(at[1]));
  if ((word & bit) == 0) // always true in the empty brick
    return;
  word &= ~bit;
  --n_occupied_;
  if (--counts_[brick] == 0)
    release(place);
}

void OccupancyMap::put_box(const Index3& first, const Index3& size, VoxelId id) {
  if (is_one_cell(size)) {
    put(first, id);
    return;
  }
  for_each_part(first, size, id, [this](const Index3& at, const BrickBox& box) { put_part(at, box); });
}

void OccupancyMap::take_box(const Index3& first, const Index3& size) {
  if (is_one_cell(size))
    return take(first);
  for_each_part(first, size, 0, [this](const Index3& at, const BrickBox& box) { take_part(at, box); });
}

void OccupancyMap::put_part(const Index3& first, const BrickBox& box) {
  const std::size_t place = brick_of(first);
  const auto brick = static_cast<std::size_t>(bricks_[place] != empty ? bricks_[place] : new_brick(place));
  const std::int32_t added = put_in_brick(box, masks_[brick].data(), ids_[brick]->of.data());
  counts_[brick] += added;
  n_occupied_ += added;
}

void OccupancyMap::take_part(const Index3& first, const BrickBox& box) {
  const std::size_t place = brick_of(first);
  if (bricks_[place] == empty)
    return;
  const auto brick = static_cast<std::size_t>(bricks_[place]);
  const std::int32_t removed = take_from_brick(box, masks_[brick].data());
  n_occupied_ -= removed;
  if ((counts_[brick] -= removed) == 0 && removed > 0)
    release(place);
}

std::int64_t OccupancyMap::bytes() const {
  const auto n = static_cast<std::int64_t>(masks_.size()) - 1; // the empty brick has no numbers
  return static_cast<std::int64_t>(bricks_.capacity() * sizeof(std::int32_t)) +
         static_cast<std::int64_t>(masks_.capacity() * sizeof(Mask) +
                                   ids_.capacity() * sizeof(std::unique_ptr<Ids>)) +
         n * static_cast<std::int64_t>(sizeof(Ids)) +
         static_cast<std::int64_t>((counts_.capacity() + unused_.capacity()) * sizeof(std::int32_t));
}

} // namespace maille::deform
