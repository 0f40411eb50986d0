#include "maille/deform/world/occupancy_map.hpp"

#include <algorithm>
#include <bit>
#include <stdexcept>

namespace maille::deform {

namespace {

constexpr int most_cells = 1 << 15;

/// Bits of a row from cell `first` to cell `last` of a brick.
std::uint16_t bits_between(int first, int last) {
  return static_cast<std::uint16_t>((0xFFFFu >> (15 - last)) & (0xFFFFu << first));
}

} // namespace

OccupancyMap::OccupancyMap(const Index3& cells) : cells_(cells) {
  for (std::size_t a = 0; a < 3; ++a) {
    if (cells[a] < 1 || cells[a] > most_cells)
      throw std::invalid_argument("OccupancyMap: 1 to 32768 cells along every axis");
    n_bricks_[a] = (cells[a] + brick_edge - 1) / brick_edge;
  }
  bricks_.assign(static_cast<std::size_t>(std::int64_t{1} * n_bricks_[0] * n_bricks_[1] * n_bricks_[2]),
                 empty);
  masks_.emplace_back();
  ids_.emplace_back();
  counts_.push_back(0);
}

VoxelId OccupancyMap::occupant(const Index3& at) const {
  if (!is_occupied(at))
    return nobody;
  const auto brick = static_cast<std::size_t>(bricks_[brick_of(at)]);
  return (*ids_[brick])[row_of(at) * brick_edge + static_cast<std::size_t>(at[0] & 15)];
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
        const Mask& mask = masks_[static_cast<std::size_t>(brick)];
        const std::uint16_t wanted =
            bits_between(std::max(low[0] - 16 * bx, 0), std::min(high[0] - 16 * bx, 15));
        for (int z = std::max(low[2], 16 * bz); z <= std::min(high[2], 16 * bz + 15); ++z)
          for (int y = std::max(low[1], 16 * by); y <= std::min(high[1], 16 * by + 15); ++y)
            if ((mask[row_of({0, y, z})] & wanted) != 0)
              return true;
      }
  return false;
}

bool OccupancyMap::is_row_blocked(const Index3& first, int n) const {
  const Index3 last{first[0] + n - 1, first[1], first[2]};
  return !has_cell(first) || !has_cell(last) || is_any_occupied(first, last);
}

std::int32_t OccupancyMap::brick_to_write(std::size_t at) {
  if (bricks_[at] != empty)
    return bricks_[at];
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

void OccupancyMap::put_row(const Index3& first, int n, VoxelId id) {
  for (int done = 0; done < n;) {
    const Index3 at{first[0] + done, first[1], first[2]};
    const int x = at[0] & 15, here = std::min(n - done, brick_edge - x);
    const auto brick = static_cast<std::size_t>(brick_to_write(brick_of(at)));
    std::uint16_t& row = masks_[brick][row_of(at)];
    const std::uint16_t wanted = bits_between(x, x + here - 1), taken = row & wanted;
    VoxelId* const ids = ids_[brick]->data() + row_of(at) * brick_edge + x;
    for (int i = 0; i < here; ++i)
      if (taken == 0 || ((row >> (x + i)) & 1) == 0)
        ids[i] = id + done + i;
    row |= wanted;
    const int added = here - std::popcount(taken);
    counts_[brick] += added;
    n_occupied_ += added;
    done += here;
  }
}

void OccupancyMap::take_row(const Index3& first, int n) {
  for (int done = 0; done < n;) {
    const Index3 at{first[0] + done, first[1], first[2]};
    const int x = at[0] & 15, here = std::min(n - done, brick_edge - x);
    done += here;
    const std::int32_t brick = bricks_[brick_of(at)];
    if (brick == empty)
      continue;
    std::uint16_t& row = masks_[static_cast<std::size_t>(brick)][row_of(at)];
    const std::uint16_t unwanted = bits_between(x, x + here - 1);
    const int removed = std::popcount(static_cast<std::uint16_t>(row & unwanted));
    row = static_cast<std::uint16_t>(row & ~unwanted);
    n_occupied_ -= removed;
    if ((counts_[static_cast<std::size_t>(brick)] -= removed) == 0 && removed > 0)
      release(brick_of(at));
  }
}

std::int64_t OccupancyMap::bytes() const {
  const auto n = static_cast<std::int64_t>(masks_.size()) - 1; // the empty one has no numbers
  return static_cast<std::int64_t>(bricks_.capacity() * sizeof(std::int32_t)) +
         static_cast<std::int64_t>(masks_.capacity() * sizeof(Mask) +
                                   ids_.capacity() * sizeof(std::unique_ptr<Ids>)) +
         n * static_cast<std::int64_t>(sizeof(Ids)) +
         static_cast<std::int64_t>((counts_.capacity() + unused_.capacity()) * sizeof(std::int32_t));
}

} // namespace maille::deform
