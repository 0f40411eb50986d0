#pragma once
/// One displacement component of a body, from metres to quanta and back.

#include "maille/scene/shortest_paths.hpp"
#include "propagate/wavefront_field.hpp"

#include <optional>
#include <span>
#include <vector>

namespace maille::deform {

/// The smallest power of two of which a field can tell 2^30 - 2 apart, so that it spans `span` [m].
double quantum_that_spans(double span);

/// Values this near to what they should be, in quanta, count as met: rounding down is off by less than one.
inline constexpr std::int64_t met_within = 1;

/// Where a component shall be in the end. `value` is what stands in the scene, or what it was cut to.
struct Target {
  std::int64_t node = 0;
  double value = 0;
  bool held = false;
};

class TiledComponent {
public:
  /// At rest. @param low <= 0, @param high >= 0: the range of values to come [m], as far as known
  TiledComponent(const Tiling& tiling, const LinkLimits& limits, int component, double low, double high);

  double quantum() const { return bounds_.quantum(); }
  const TileField& field() const { return field_; }
  TileField& field() { return field_; }
  double metres(std::int64_t value) const { return static_cast<double>(value) * quantum(); }

  void rest();
  double set_state(std::span<const double> state);
  /// x = max(x, value - d(i, end)), or x = min(x, value + d(end, i)).
  void run(Way way, std::span<const PathEnd> ends);
  /// Moves, and replaces the values of targets that the limits do not admit.
  void move(std::span<Target> targets);

  std::int64_t bytes() const;

private:
  std::int64_t quanta(double value) const;
  /// Makes the field span values from `low` to `high` [m] besides its own, with coarser quanta if it must; or,
  /// if `may_cut`, rather by cutting its own values, and returns what they were.
  std::optional<TileField::Copy> make_room(double low, double high, bool may_cut);
  void coarsen(int bits);
  bool are_met(std::span<const Seed> seeds) const;
  std::vector<Seed> seeds_of(std::span<const Target> targets) const;

  // Admission, in quanta; see admit().
  void admit(std::span<Target> targets);
  /// The best that the seeds leave each of `at`, without regard to the state.
  std::vector<std::int64_t> envelope(Way way, std::span<const Seed> seeds, std::span<const Seed> at);

  const Tiling* tiling_;
  TileBounds bounds_;
  TileField field_;
  std::optional<TileField> scratch_; ///< for envelopes and repairs
};

} // namespace maille::deform
