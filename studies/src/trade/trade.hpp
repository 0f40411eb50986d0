#pragma once
/// Error against cost on one scene: every method on several lattices and to several tolerances, against the
/// best reference; the Pareto fronts over time and memory are the trade-offs worth having.

#include "maille/scene/answer.hpp"
#include "results/measure_values.hpp"
#include "trade/lattices.hpp"

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
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
  bool on_time_front = false, on_memory_front = false;
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

/// Measures every way once, then the quick ones again, in turns, up to `settings.repetitions` times; marks
/// the two fronts. Errors: the answer is carried to the scene's own nodes (between_lattices) and compared
/// there. Each measurement of finite elements makes its mesh, matrix and factor anew.
/// @pre  all are methods; tolerances lie between 0 and 1
Trade measure_trade(Lattices& lattices, const TradeSettings& settings, const Control& control);

/// Marks the rows on the fronts of error over time and error over memory: settled ones with an error.
void mark_fronts(std::vector<TradeRow>& rows);

/// For people: the rows of the fronts, `t` on that over time, `m` on that over memory; all of them where
/// asked for, and where no row is on a front.
std::string table(const Scene& scene, const Trade& trade, bool all);
nlohmann::ordered_json json(const Scene& scene, const Trade& trade);
/// A header line and one line a row: what choose() learns from.
std::string csv(const Scene& scene, const Trade& trade);

/// Draws both fronts, over time and over memory, beside each other: one colour a method, the front as a step
/// line, the reference's own error as a floor. By gnuplot, as SVG or PNG by the file's ending.
/// @return why the picture could not be drawn; nothing on success
std::optional<std::string> draw_trade(const Scene& scene, const Trade& trade,
                                      const std::filesystem::path& file);

/// One way to answer: what it costs and how far off it is; less is better in both.
struct CostAndError {
  double cost = 0, error = 0;
};

/// The points that no other point dominates (better in one, not worse in both), from the cheapest to the
/// dearest. Equal points are all included; points with a coordinate that is not finite are not.
/// Cost  O(n log n)
std::vector<std::size_t> pareto_front(std::span<const CostAndError> points);

} // namespace maille::studies
