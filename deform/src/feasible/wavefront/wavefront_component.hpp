#pragma once
/// One displacement component of a body, from metres to quanta and back.

#include "feasible/wavefront/wavefront_field.hpp"
#include "maille/scene/link_limits.hpp"

#include <optional>
#include <span>

namespace maille::deform {

/// The smallest power of two of which a field can tell 2^30 - 2 apart, so that it spans `span` [m].
double quantum_that_spans(double span);

/// Values this near to what they should be, in quanta, count as met: rounding down is off by less than one.
inline constexpr std::int64_t met_within = 1;

/// Target of a component. `value` is that of the scene, or its clipped value.
struct Target {
  std::int64_t node = 0;
  double value = 0;
  bool held = false;
};

/// Allocates at first use, or for more values than before.
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
  /// Moves, and replaces the values of targets that the limits do not permit.
  void move(std::span<Target> targets);

private:
  std::int64_t quanta(double value) const;
  /// Makes the field span values from `low` to `high` [m] besides its own, with coarser quanta if necessary;
  /// or, if `may_cut`, by cutting its own values: returns true if so, and `before_` has the uncut values.
  bool make_room(double low, double high, bool may_cut);
  void coarsen(int bits);
  bool are_met(std::span<const Seed> seeds) const;
  void find_seeds(std::span<const Target> targets);

  // Clipping, in quanta; see clip().
  void clip(std::span<Target> targets);
  /// The best that the seeds leave each of `at`, without regard to the state.
  void envelope(Way way, std::span<const Seed> seeds, std::span<const Seed> at, List<std::int64_t>& values);

  const Tiling* tiling_;
  TileIntervals bounds_;
  TileField field_;
  std::optional<TileField> scratch_; ///< for envelopes and projections
  TileField::Copy before_;
  List<Seed> seeds_, holds_, moves_;    ///< all that is asked; of these, what stays and what moves
  List<std::int64_t> highest_, lowest_; ///< envelopes
};

} // namespace maille::deform
