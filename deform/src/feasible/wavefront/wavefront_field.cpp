#include "feasible/wavefront/wavefront_field.hpp"

#include "lattice/field_memory.hpp"

#include <algorithm>
#include <limits>

namespace maille::deform {

namespace {

constexpr std::size_t index(std::int32_t i) {
  return static_cast<std::size_t>(i);
}
std::size_t n_slots(const Tiling& tiling) {
  return index(tiling.n_tiles()) * index(tiling.volume());
}

} // namespace

TileField::TileField(const Tiling& tiling)
    : tiling_(&tiling), visit_tile_(best_visit_tile()), values_(n_slots(tiling)),
      queue_(index(tiling.n_tiles())), is_recorded_(index(tiling.n_tiles()), false) {
  recorded_.reserve(index(tiling.n_tiles()));
  fill(0, 0);
}

void TileField::fill(std::int64_t value, std::int64_t offset) {
  offset_ = offset;
  even_value_ = static_cast<std::int32_t>(value - offset);
  std::fill_n(values_.data(), n_slots(*tiling_), even_value_);
  is_even_ = true;
}

std::pair<std::int64_t, std::int64_t> TileField::range() const {
  if (is_even_)
    return {offset_ + even_value_, offset_ + even_value_};
  std::int32_t low = std::numeric_limits<std::int32_t>::max(), high = -low;
  for (std::int32_t t = 0; t < tiling_->n_tiles(); ++t) {
    const std::int32_t* const values = tile(t);
    for (int layer = 0; layer < tiling_->layers(); ++layer)
      for (std::uint64_t bits = tiling_->node_bits(t, layer); bits != 0; bits &= bits - 1) {
        const std::int32_t v = values[layer * tile_layer + __builtin_ctzll(bits)];
        low = std::min(low, v);
        high = std::max(high, v);
      }
  }
  return {offset_ + low, offset_ + high};
}

bool TileField::touches_its_range() const {
  const auto [low, high] = range();
  return low <= offset_ - largest_value || high >= offset_ + largest_value;
}

void TileField::set_offset(std::int64_t offset) {
  const std::int64_t by = offset_ - offset;
  const auto moved = [by](std::int32_t v) {
    return static_cast<std::int32_t>(std::clamp<std::int64_t>(v + by, -largest_value, largest_value));
  };
  offset_ = offset;
  even_value_ = moved(even_value_);
  std::transform(values_.data(), values_.data() + n_slots(*tiling_), values_.data(), moved);
}

void TileField::coarsen(int bits) {
  const std::int64_t offset = offset_ >> bits; // rounds down, as do the values
  const auto coarse = [&](std::int32_t v) {
    return static_cast<std::int32_t>(((offset_ + v) >> bits) - offset);
  };
  even_value_ = coarse(even_value_);
  std::transform(values_.data(), values_.data() + n_slots(*tiling_), values_.data(), coarse);
  offset_ = offset;
}

void TileField::run(Way way, TileIntervals& bounds, std::span<const Seed> seeds) {
  const auto beyond = [&](const Seed& seed) {
    const std::int64_t change = seed.value - value(seed.place);
    return static_cast<std::int32_t>(way == Way::raise ? change : -change);
  };
  std::int32_t largest = 0;
  for (const Seed& seed : seeds)
    largest = std::max(largest, beyond(seed));
  if (largest == 0)
    return;
  queue_.start(largest, bounds.mean_length());
  for (const Seed& seed : seeds)
    if (const std::int32_t change = beyond(seed); change > 0) {
      touch(seed.place.tile);
      values_[at(seed.place)] = static_cast<std::int32_t>(seed.value - offset_);
      queue_.push(seed.place.tile, change);
    }
  work_off(way, bounds);
}

void TileField::run_everywhere(Way way, TileIntervals& bounds) {
  queue_.start(1, 1);
  for (std::int32_t t = 0; t < tiling_->n_tiles(); ++t)
    queue_.push(t, 1);
  work_off(way, bounds);
}

void TileField::work_off(Way way, TileIntervals& bounds) {
  Visit visit;
  visit.way = way;
  visit.layers = tiling_->layers();
  is_even_ = false;
  for (std::int32_t t = queue_.pop(); t >= 0; t = queue_.pop()) {
    ++n_visits_;
    const std::array<std::int32_t, 6>& around = tiling_->neighbours(t);
    if (is_recording_) {
      touch(t);
      for (const std::int32_t other : around)
        if (other >= 0)
          touch(other);
    }
    visit.values = tile(t);
    visit.bounds = bounds.block(t);
    if (!visit.bounds)
      visit.even = bounds.even(t);
    for (std::size_t d = 0; d < around.size(); ++d)
      visit.neighbours[d] = around[d] >= 0 ? tile(around[d]) : nullptr;
    if (const std::int32_t next = queue_.peek(); next >= 0)
      prefetch(bounds, next);
    visit_tile_(visit);
    for (std::size_t d = 0; d < around.size(); ++d)
      if (visit.violations[d] > 0)
        queue_.push(around[d], visit.violations[d]);
  }
}

/// Prefetches the data of the next visit; tiles are too far apart for the hardware prefetcher.
void TileField::prefetch(const TileIntervals& bounds, std::int32_t next) const {
  const auto fetch = [](const std::int32_t* first, int n) {
    for (int i = 0; i < n; i += line_of_floats)
      __builtin_prefetch(first + i, 0, 2);
  };
  fetch(tile(next), tiling_->volume());
  if (const std::int32_t* const block = bounds.known_block(next))
    fetch(block, bounds.layout().size());
}

void TileField::begin() {
  for (const std::int32_t t : recorded_)
    is_recorded_[index(t)] = false;
  recorded_.clear();
  record_.clear();
  is_recording_ = true;
  was_even_ = is_even_;
}

void TileField::touch(std::int32_t t) {
  if (!is_recording_ || is_recorded_[index(t)])
    return;
  is_recorded_[index(t)] = true;
  recorded_.push_back(t);
  if (!was_even_)
    record(t);
}

void TileField::record(std::int32_t t) {
  const std::size_t needed = record_.size() + index(tiling_->volume());
  if (needed > record_.capacity()) // doubled, but never more than all values
    record_.reserve(std::clamp(2 * record_.capacity(), needed, std::max(needed, n_slots(*tiling_))));
  record_.insert(record_.end(), tile(t), tile(t) + tiling_->volume());
}

void TileField::undo_run() {
  const auto volume = index(tiling_->volume());
  for (std::size_t i = 0; i < recorded_.size(); ++i) {
    if (was_even_)
      std::fill_n(tile(recorded_[i]), volume, even_value_);
    else
      std::copy_n(record_.begin() + static_cast<std::ptrdiff_t>(i * volume), volume, tile(recorded_[i]));
  }
  is_even_ = was_even_;
  is_recording_ = false;
}

void TileField::copy_to(Copy& copy) const {
  const std::size_t n = is_even_ ? std::min<std::size_t>(1, n_slots(*tiling_)) : n_slots(*tiling_);
  copy.offset = offset_;
  copy.is_even = is_even_;
  copy.values.assign(values_.data(), values_.data() + n);
}

void TileField::restore(const Copy& copy) {
  if (copy.is_even) {
    fill(copy.offset + copy.values[0], copy.offset);
    return;
  }
  offset_ = copy.offset;
  is_even_ = false;
  std::ranges::copy(copy.values, values_.data());
}

} // namespace maille::deform
