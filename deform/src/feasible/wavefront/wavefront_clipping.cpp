// What clipping.cpp does in metres by Dijkstra, in quanta by the wavefront.
#include "feasible/wavefront/wavefront_component.hpp"

#include <algorithm>

namespace maille::deform {

void TiledComponent::envelope(Way way, std::span<const Seed> seeds, std::span<const Seed> at,
                              List<std::int64_t>& values) {
  // Only values among those of `at` matter: bounds beyond all of them are inactive.
  const auto [low, high] = std::ranges::minmax(at, {}, &Seed::value);
  const std::int64_t nothing = way == Way::lower ? high.value + 1 : low.value - 1;
  if (!scratch_)
    scratch_.emplace(*tiling_);
  scratch_->fill(nothing, low.value + (high.value - low.value) / 2);
  scratch_->run(way, bounds_, seeds);
  values.clear();
  values.reserve(at.size());
  for (const Seed& seed : at)
    values.push_back(scratch_->value(seed.place));
}

void TiledComponent::clip(std::span<Target> targets) {
  find_seeds(targets);
  List<Seed>& all = seeds_;
  const auto n_holds = static_cast<std::size_t>(std::ranges::count_if(targets, &Target::held));
  holds_.clear();
  holds_.reserve(n_holds);
  moves_.clear();
  moves_.reserve(targets.size() - n_holds);
  for (std::size_t i = 0; i < all.size(); ++i)
    if (targets[i].held)
      holds_.push_back(all[i]);
  const auto cut = [&](std::size_t i, std::int64_t value) {
    all[i].value = value;
    targets[i].value = metres(value);
  };

  // Into the interval that the holds alone leave each move.
  envelope(Way::lower, holds_, all, highest_);
  envelope(Way::raise, holds_, all, lowest_);
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (targets[i].held)
      continue;
    if (all[i].value > highest_[i] + met_within)
      cut(i, highest_[i]);
    else if (all[i].value < lowest_[i] - met_within)
      cut(i, lowest_[i]);
    moves_.push_back(all[i]);
  }

  if (moves_.empty())
    return;
  // Moves that contradict each other: the mean of the nearest feasible values below and above. Rounded down
  // it is feasible among the moves and against the holds, because both are and bounds are whole.
  List<std::int64_t>&minorant = highest_, &majorant = lowest_;
  envelope(Way::lower, moves_, moves_, minorant);
  envelope(Way::raise, moves_, moves_, majorant);
  for (std::size_t i = 0, m = 0; i < all.size(); ++i) {
    if (targets[i].held)
      continue;
    if (all[i].value > minorant[m] + met_within || all[i].value < majorant[m] - met_within)
      cut(i, (minorant[m] + majorant[m]) >> 1);
    ++m;
  }
}

} // namespace maille::deform
