// What admission.cpp does in metres by Dijkstra, in quanta by the wavefront.
#include "propagate/wavefront_component.hpp"

#include <algorithm>

namespace maille::deform {

std::vector<std::int64_t> TiledComponent::envelope(Way way, std::span<const Seed> seeds,
                                                   std::span<const Seed> at) {
  // Only values among those of `at` matter: what lies beyond them all binds nobody.
  const auto [low, high] = std::ranges::minmax(at, {}, &Seed::value);
  const std::int64_t nothing = way == Way::lower ? high.value + 1 : low.value - 1;
  if (!scratch_)
    scratch_.emplace(*tiling_);
  scratch_->fill(nothing, low.value + (high.value - low.value) / 2);
  scratch_->run(way, bounds_, seeds);
  std::vector<std::int64_t> values;
  values.reserve(at.size());
  for (const Seed& seed : at)
    values.push_back(scratch_->value(seed.place));
  return values;
}

void TiledComponent::admit(std::span<Target> targets) {
  std::vector<Seed> all = seeds_of(targets), holds, moves;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (targets[i].held)
      holds.push_back(all[i]);
  const auto cut = [&](std::size_t i, std::int64_t value) {
    all[i].value = value;
    targets[i].value = metres(value);
  };

  // Into the interval that the holds alone leave each move.
  const std::vector<std::int64_t> highest = envelope(Way::lower, holds, all);
  const std::vector<std::int64_t> lowest = envelope(Way::raise, holds, all);
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (targets[i].held)
      continue;
    if (all[i].value > highest[i] + met_within)
      cut(i, highest[i]);
    else if (all[i].value < lowest[i] - met_within)
      cut(i, lowest[i]);
    moves.push_back(all[i]);
  }

  if (moves.empty())
    return;
  // Moves that contradict each other: the mean of the nearest legal values below and above. Rounded down it is
  // legal among the moves and against the holds, because both are and bounds are whole.
  const std::vector<std::int64_t> minorant = envelope(Way::lower, moves, moves);
  const std::vector<std::int64_t> majorant = envelope(Way::raise, moves, moves);
  for (std::size_t i = 0, m = 0; i < all.size(); ++i) {
    if (targets[i].held)
      continue;
    if (all[i].value > minorant[m] + met_within || all[i].value < majorant[m] - met_within)
      cut(i, (minorant[m] + majorant[m]) >> 1);
    ++m;
  }
}

} // namespace maille::deform
