#include "feasible/wavefront/wavefront_component.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace maille::deform {

namespace {

/// What a field spans. Two less than it could store, so that envelopes have a value beyond all others.
constexpr std::int64_t widest = 2 * std::int64_t{largest_value} - 2;
/// Values are counted exactly in doubles.
constexpr double largest_count = 1 / std::numeric_limits<double>::epsilon();

std::int64_t middle(std::int64_t low, std::int64_t high) {
  return low + (high - low) / 2;
}

} // namespace

double quantum_that_spans(double span) {
  if (!(span > 0))
    return 1;
  int exponent = 0;
  std::frexp(span / static_cast<double>(widest), &exponent); // < 2^exponent
  // Neither so small that it vanishes nor so large that sums overflow.
  return std::ldexp(1.0, std::clamp(exponent, -1000, 960));
}

namespace {

/// Enough for what is known to come, or for what the body's slack allows, whichever is less: handles may be
/// far away.
double first_quantum(const Tiling& tiling, const LinkLimits& limits, int component, double to_come) {
  const double slack = 2 * slack_across(tiling.specimen().grid, limits, component);
  return quantum_that_spans(slack == 0 || to_come == 0 ? std::max(slack, to_come) : std::min(slack, to_come));
}

} // namespace

TiledComponent::TiledComponent(const Tiling& tiling, const LinkLimits& limits, int component, double low,
                               double high)
    : tiling_(&tiling),
      bounds_(tiling, limits, component, first_quantum(tiling, limits, component, high - low)),
      field_(tiling) {
  if ((high - low) / quantum() <= static_cast<double>(widest))
    field_.fill(0, middle(quanta(low), quanta(high)));
}

void TiledComponent::rest() {
  field_.fill(0, std::abs(field_.offset()) <= largest_value ? field_.offset() : 0);
}

std::int64_t TiledComponent::quanta(double value) const {
  return static_cast<std::int64_t>(std::floor(value / quantum()));
}

void TiledComponent::coarsen(int bits) {
  bounds_.set_quantum(std::ldexp(quantum(), bits));
  field_.coarsen(bits);
}

bool TiledComponent::make_room(double low, double high, bool may_cut) {
  for (int bits = 0; std::max(-low, high) / quantum() > largest_count; bits = std::min(bits + 1, 60))
    coarsen(bits);
  std::int64_t lowest = quanta(low), highest = quanta(high);
  if (field_.spans(lowest, highest))
    return false;
  const auto [least, most] = field_.range();
  const std::int64_t from = std::min(lowest, least), to = std::max(highest, most);
  if (to - from > widest && may_cut && highest - lowest <= largest_value) {
    field_.copy_to(before_);
    field_.set_offset(middle(lowest, highest));
    return true;
  }
  int bits = 0;
  while ((to >> bits) - (from >> bits) > widest)
    ++bits;
  if (bits > 0)
    coarsen(bits);
  field_.set_offset(middle(from >> bits, to >> bits));
  return false;
}

void TiledComponent::run(Way way, std::span<const PathEnd> ends) {
  if (ends.empty())
    return;
  const auto [low, high] = std::ranges::minmax(ends, {}, &PathEnd::potential);
  make_room(low.potential, high.potential, false);
  seeds_.clear();
  seeds_.reserve(ends.size());
  for (const PathEnd& end : ends)
    seeds_.push_back({tiling_->place(end.node), quanta(end.potential)});
  field_.run(way, bounds_, seeds_);
}

void TiledComponent::find_seeds(std::span<const Target> targets) {
  seeds_.clear();
  seeds_.reserve(targets.size());
  for (const Target& target : targets)
    seeds_.push_back({tiling_->place(target.node), quanta(target.value)});
}

bool TiledComponent::are_met(std::span<const Seed> seeds) const {
  return std::ranges::all_of(
      seeds, [&](const Seed& seed) { return std::abs(field_.value(seed.place) - seed.value) <= met_within; });
}

void TiledComponent::move(std::span<Target> targets) {
  if (targets.empty())
    return;
  bool may_cut_state = true, is_clipped = false;
  for (;;) {
    const auto [low, high] = std::ranges::minmax(targets, {}, &Target::value);
    const bool is_cut = make_room(low.value, high.value, may_cut_state);
    find_seeds(targets);
    // Values that are all the same never contradict each other.
    const bool is_certain = is_clipped || low.value == high.value;
    if (!is_cut && !is_certain)
      field_.begin();
    field_.run(Way::raise, bounds_, seeds_);
    field_.run(Way::lower, bounds_, seeds_);
    if (is_cut && field_.touches_its_range()) {
      // Some values were out of the window's reach although nothing moved them: they must fit in, too.
      field_.restore(before_);
      may_cut_state = false;
      continue;
    }
    // The values are those of a feasible state if and only if the clamped state has them.
    if (is_certain || are_met(seeds_)) {
      field_.keep();
      return;
    }
    if (is_cut)
      field_.restore(before_);
    else
      field_.undo_run();
    clip(targets);
    is_clipped = true;
  }
}

double TiledComponent::set_state(std::span<const double> state) {
  field_.fill(0, 0);
  double low = 0, high = 0;
  const auto each_node = [&](const auto& visit) {
    for (std::int32_t t = 0; t < tiling_->n_tiles(); ++t)
      tiling_->for_each_node(t, visit);
  };
  each_node([&](std::int32_t, int, std::int64_t node) {
    low = std::min(low, state[node]);
    high = std::max(high, state[node]);
  });
  make_room(low, high, false);
  if (!scratch_)
    scratch_.emplace(*tiling_);
  scratch_->fill(0, field_.offset());
  each_node([&](std::int32_t tile, int slot, std::int64_t node) {
    field_.tile(tile)[slot] = static_cast<std::int32_t>(quanta(state[node]) - field_.offset());
    scratch_->tile(tile)[slot] = field_.tile(tile)[slot];
  });
  field_.run_everywhere(Way::raise, bounds_);
  scratch_->run_everywhere(Way::lower, bounds_);
  // Rounded down, the mean of two feasible states is feasible: bounds are whole.
  std::int64_t largest = 0;
  each_node([&](std::int32_t tile, int slot, std::int64_t node) {
    std::int32_t& value = field_.tile(tile)[slot];
    const auto mean = static_cast<std::int32_t>((std::int64_t{value} + scratch_->tile(tile)[slot]) >> 1);
    value = mean;
    const std::int64_t was = quanta(state[node]) - field_.offset();
    largest = std::max(largest, std::abs(mean - was));
  });
  return metres(largest);
}

} // namespace maille::deform
