#pragma once
/// Error against cost on one scene: all methods on several lattices and with several tolerances, against the
/// best reference. python/maille/_trade.py marks the Pareto fronts over time and memory afterwards.

#include "maille/scene/answer.hpp"
#include "results/measure_values.hpp"
#include "trade/lattices.hpp"

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace maille::studies {

/// A configuration: method, lattice and tolerance.
struct Way {
  std::string method;
  int halvings = 0; ///< of the scene's spacing, see Lattices::at
  std::optional<double>
      tolerance; ///< for methods with a tolerance: scene.relaxation.tolerance, or the residual of CG

  friend bool operator==(const Way&, const Way&) = default;
};

/// Uncalibrated forecast of choose(), stored with the measurement: see Probes.
struct RawPrediction {
  std::optional<double> error, seconds;
  int probe_halvings = -1; ///< see Probes::halvings
};

/// Result of one configuration.
struct TradeRow {
  Way way;
  Index3 cells{};         ///< cells of its lattice
  Vec3 spacing{};         ///< [m]
  std::int64_t nodes = 0; ///< of matter
  Status status = Status::done;
  std::string algorithm, message;
  /// Medians of the smaller of wall-clock and processor time: with one thread this is the wall-clock time of
  /// an idle machine.
  Seconds seconds;
  double wall_seconds = 0; ///< median, set-up and solve
  int repetitions = 0;
  std::int64_t bytes = 0;
  std::int64_t iterations = 0;
  std::optional<ErrorNorms> error;  ///< over the scene's free nodes; none for the reference itself
  std::vector<MeasureRow> measures; ///< measures of the scene, on this lattice
  RawPrediction predicted;
};

struct TradeSettings {
  std::vector<std::string> methods;            ///< empty: default_trade_methods()
  std::vector<int> halvings{-3, -2, -1, 0, 1}; ///< lattices, see Lattices::at
  std::vector<double> tolerances{1e-1, 1e-2, 1e-3,
                                 1e-4}; ///< for lattice methods; finite elements: 1e-4, 1e-10
  std::string reference = "best";       ///< or a method, on the scene's own lattice
  double reference_seconds = 60;        ///< for the reference "best"
  double row_seconds = 60; ///< longer rows are stopped; finite elements with a longer forecast are skipped
  int repetitions = 3;     ///< for rows below a second
};

/// All methods except the oracles: `dijkstra` equals `limits`, and `calculix` equals `fem_q1`.
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
  bool is_whole = false;                     ///< false if it was interrupted

  /// True if the reference has no answer, the run was interrupted, or a method failed (refusing is a valid
  /// result).
  bool any_failed() const;
};

/// Measures every configuration once, then repeats the fast ones in turns, up to `settings.repetitions`
/// times. Errors: the answer is transferred to the scene's nodes (between_lattices) and compared there. Each
/// measurement of finite elements rebuilds mesh, matrix and factor.
/// @pre  all names are methods; tolerances are between 0 and 1
Trade measure_trade(Lattices& lattices, const TradeSettings& settings, const Control& control);

nlohmann::ordered_json json(const Scene& scene, const Trade& trade);
/// Text before the rows: question and reference; text after them: what is missing.
std::string head_in_words(const Scene& scene, const Trade& trade);
std::string notes_in_words(const Trade& trade);
/// A header line and one line per row, without fronts: training data of `maille study choose`.
std::string csv(const Scene& scene, const Trade& trade);

} // namespace maille::studies
