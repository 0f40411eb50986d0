#pragma once
/// Every method at the extremes: `studies/lab/run stability`.

#include "bench/bench_report.hpp"
#include "maille/scene/answer.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace maille::lab {

/// What one method made of one extreme.
struct StabilityCell {
  std::string extreme, setting; ///< "Poisson ratio", "0.49999, poked"
  std::string method;
  std::string outcome; ///< settled, clamped, budget reached, refused, failed, interrupted; died: see `broken`
  std::string note;    ///< the answer's message
  std::optional<double> violation; ///< largest, in units of a link's rest length; unset without an answer
  bool is_finite = true;           ///< every number of the answer
  std::int64_t iterations = 0;
  std::optional<double> over_normal; ///< iterations over those of the extreme's normal setting
  std::optional<double> error; ///< largest, over the largest true displacement; unset where no truth is known
  double seconds = 0;
  std::string broken; ///< which promise, in words; empty where all are kept
};

struct StabilityOptions {
  /// Fewer drags, cycles, random scenes and cells along the longest body; without quadratic elements
  bool quick = false;
  std::vector<std::string> extremes; ///< only these; empty: all, and random scenes and worlds
};

struct Stability {
  std::vector<StabilityCell> cells;
  bool is_quick = false; ///< as StabilityOptions::quick
  std::int64_t cells_asked = 0;
  std::int64_t random_scenes = 0;
  std::vector<std::string> broken_random_scenes; ///< each with its seed
  std::int64_t random_worlds = 0;
  std::vector<std::string> broken_random_worlds; ///< likewise
  /// The largest change of the state at the same point of a cycle, over the largest displacement, over all
  /// cycles.
  std::optional<double> cyclic_drift_relaxed, cyclic_drift_coupled;
};

/// Names of the extremes.
std::vector<std::string> stability_extremes();

/// Asks every method every extreme, each in a process of its own that is ended when it takes too long, so
/// that what crashes or hangs is a row and not the end; then random scenes, and random worlds.
/// Cost  some minutes with one thread; `quick` some seconds
Stability stability(const StabilityOptions& options, const Control& control);

/// Rows, and the checks cells_total, cells_broken, random_scenes, random_scenes_broken, random_worlds,
/// random_worlds_broken, cyclic_drift_relaxed, cyclic_drift_coupled.
BenchReport stability_report(const Stability& stability);
/// The page docs/stability.md.
std::string stability_page(const Stability& stability);

} // namespace maille::lab
