#pragma once
/// Error against cost on one scene: every method on several lattices and to several tolerances, against the
/// best reference. The Pareto fronts over time and memory are marked afterwards (python/maille/_trade.py).

#include "maille/scene/answer.hpp"
#include "results/measure_values.hpp"
#include "trade/lattices.hpp"

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace maille::studies {

/// One way to answer a scene.
struct Way {
  std::string method;
  int halvings = 0; ///< of the scene's spacing, see Lattices::at
  std::optional<double>
      tolerance; ///< of methods that have one: scene.relaxation.tolerance, or the residual of CG

  friend bool operator==(const Way&, const Way&) = default;
};

/// What choose() would have expected before it knew its table, kept beside what was measured: see Probes.
struct RawPrediction {
  std::optional<double> error, seconds;
  int probe_halvings = -1; ///< see Probes::halvings
};

/// What one way came to.
struct TradeRow {
  Way way;
  Index3 cells{};         ///< of its lattice
  Vec3 spacing{};         ///< [m]
  std::int64_t nodes = 0; ///< of matter
  Status status = Status::done;
  std::string algorithm, message;
  /// Medians. The smaller of wall-clock and processor time: with one thread this is the wall-clock time of an
  /// otherwise idle machine.
  Seconds seconds;
  double wall_seconds = 0; ///< median, set-up and solve
  int repetitions = 0;
  std::int64_t bytes = 0;
  std::int64_t iterations = 0;
  std::optional<ErrorNorms>
      error; ///< over the scene's own nodes that are neither held nor moved; none of the reference itself
  std::vector<MeasureRow> measures; ///< of the scene, on the lattice of the row
  RawPrediction predicted;
};

struct TradeSettings {
  std::vector<std::string> methods;            ///< empty: default_trade_methods()
  std::vector<int> halvings{-3, -2, -1, 0, 1}; ///< lattices, see Lattices::at
  std::vector<double> tolerances{1e-1, 1e-2, 1e-3,
                                 1e-4}; ///< of lattice methods that have one; finite elements: 1e-4 and 1e-10
  std::string reference = "best";       ///< or a method, on the scene's own lattice
  double reference_seconds = 60;        ///< for the reference "best"
  double row_seconds =
      60; ///< a row that takes longer is cut short; finite elements that are expected to are not tried
  int repetitions = 3; ///< of rows below a second
};

/// All but the oracles: `dijkstra` answers as `limits`, and `calculix` as `fem_q1`.
std::vector<std::string> default_trade_methods();

struct Trade {
  TradeSettings settings;
  int threads = 1;
  std::string reference_algorithm;
  Status reference_status = Status::done;
  std::string reference_message;
  Seconds reference_seconds;
  std::optional<ErrorNorms> reference_error; ///< the reference's own, see BestReference
  std::vector<TradeRow> rows;                ///< methods in order, coarse lattices first
  bool is_whole = false;                     ///< false where it was interrupted

  /// True where the reference has no answer, it was interrupted, or a method failed (one that refuses is a
  /// result).
  bool any_failed() const;
};

/// Measures every way once, then the quick ones again, in turns, up to `settings.repetitions` times.
/// Errors: the answer is carried to the scene's own nodes (between_lattices) and compared
/// there. Each measurement of finite elements makes its mesh, matrix and factor anew.
/// @pre  all are methods; tolerances lie between 0 and 1
Trade measure_trade(Lattices& lattices, const TradeSettings& settings, const Control& control);

nlohmann::ordered_json json(const Scene& scene, const Trade& trade);
/// For people: the question and the reference, above the rows; and below them what is missing.
std::string head_in_words(const Scene& scene, const Trade& trade);
std::string notes_in_words(const Trade& trade);
/// A header line and one line a row, without fronts: what `maille study choose` learns from.
std::string csv(const Scene& scene, const Trade& trade);

} // namespace maille::studies
