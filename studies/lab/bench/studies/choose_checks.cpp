#include "bench/studies/studies.hpp"

#include "bench/studies/scene_maker.hpp"
#include "choose/choose.hpp"
#include "compare/methods.hpp"
#include "trade/measure.hpp"

#include <fmt/format.h>

#include <cmath>
#include <ctime>
#include <limits>

namespace maille::lab {

namespace {

constexpr std::uint32_t seed = 20261121;
constexpr double most_seconds = 300, reference_seconds = 10;
/// Draws per promise: probes are cheap, and requests that cannot be met are skipped.
constexpr int most_draws_per_promise = 5;

/// How the promises of one run were kept.
struct Tally {
  int draws = 0, promises = 0, errors_kept = 0, times_kept = 0, wall_kept = 0, errors_within = 0,
      times_within = 0, without_reference = 0;
  double log_error = 0, log_time = 0; ///< sums of the logarithms of measured over expected
};

struct Outcome {
  Measured run;
  double error = 0;
};

/// What was chosen, done: the median of three.
Outcome do_chosen(Lattices& lattices, const Candidate& chosen, const Displacement& reference) {
  const LatticeScene lattice = lattices.at(chosen.way.halvings);
  std::vector<double> seconds, wall;
  Outcome outcome;
  for (int turn = 0; turn < 3; ++turn) {
    outcome.run = measure(*lattice.scene, chosen.way.method, chosen.way.tolerance, {});
    seconds.push_back(outcome.run.answer.seconds.total());
    wall.push_back(outcome.run.wall_seconds);
  }
  outcome.run.answer.seconds = {0, median(seconds)};
  outcome.run.wall_seconds = median(wall);
  outcome.error = std::numeric_limits<double>::infinity();
  if (is_converged(outcome.run.answer.status))
    outcome.error =
        compare(lattices.scene(),
                between_lattices(*lattice.scene, outcome.run.answer.displacement, lattices.scene()),
                reference)
            .relative_l2;
  return outcome;
}

nlohmann::ordered_json row(const UnseenScene& asked, const Candidate& chosen, const Outcome& outcome,
                           const std::optional<ErrorNorms>& reference_error, std::int64_t nodes) {
  return {{"shape", asked.shape},
          {"load", asked.load},
          {"material", asked.material},
          {"nodes", nodes},
          {"wish_error", asked.error},
          {"wish_ms", 1e3 * asked.seconds},
          {"method", chosen.way.method},
          {"spacing", std::exp2(-chosen.way.halvings)},
          {"tolerance", chosen.way.tolerance.value_or(0)},
          {"expected_error", chosen.error.median},
          {"promised_error", chosen.error.high},
          {"error", outcome.error},
          {"reference_error", reference_error ? reference_error->relative_l2 : 0},
          {"error_kept", outcome.error <= asked.error},
          {"expected_ms", 1e3 * chosen.seconds.median},
          {"promised_ms", 1e3 * chosen.seconds.high},
          {"ms", 1e3 * outcome.run.answer.seconds.total()},
          {"wall_ms", 1e3 * outcome.run.wall_seconds},
          {"time_kept", outcome.run.answer.seconds.total() <= asked.seconds}};
}

/// Asks, does, measures; adds nothing where nothing was promised.
void ask(const UnseenScene& asked, const Calibration& calibration, Methods& methods, BenchReport& report,
         Tally& tally) {
  ++tally.draws;
  Lattices lattices(asked.text, "unseen.toml");
  Wish wish;
  wish.error = asked.error;
  wish.seconds = asked.seconds;
  const Choice choice = choose(lattices, wish, calibration, {});
  if (!choice.chosen)
    return;
  const BestReference reference = best_reference(lattices.scene(), reference_seconds, {}, methods);
  if (!reference.estimated_error || reference.estimated_error->relative_l2 > asked.error) {
    ++tally.without_reference;
    return;
  }
  const Outcome outcome = do_chosen(lattices, *choice.chosen, reference.answer.displacement);
  const double seconds = outcome.run.answer.seconds.total();
  ++tally.promises;
  tally.errors_kept += outcome.error <= asked.error;
  tally.times_kept += seconds <= asked.seconds;
  tally.wall_kept += outcome.run.wall_seconds <= asked.seconds;
  tally.errors_within += outcome.error <= choice.chosen->error.high;
  tally.times_within += seconds <= choice.chosen->seconds.high;
  tally.log_error += std::log(outcome.error / choice.chosen->error.median);
  tally.log_time += std::log(seconds / choice.chosen->seconds.median);
  report.rows.push_back(row(asked, *choice.chosen, outcome, reference.estimated_error,
                            lattices.scene().specimen.n_matter_nodes()));
}

void add_notes(const Tally& tally, BenchReport& report) {
  const double n = std::max(tally.promises, 1);
  report.notes.push_back(fmt::format(
      "choose: {} scenes drawn, {} promises; to the other wishes it answered that nothing meets them{}",
      tally.draws, tally.promises,
      tally.without_reference > 0
          ? fmt::format(" ({} promises were passed over: their reference is not known to be within the wish)",
                        tally.without_reference)
          : ""));
  report.notes.push_back(fmt::format(
      "choose: times are the smaller of wall-clock and processor time; by the wall clock alone {:.3g} of "
      "the promises were kept on this machine with its other load",
      tally.wall_kept / n));
  report.notes.push_back(
      fmt::format("choose: measured over expected, geometric mean: error {:.3g}, time {:.3g}; within the "
                  "upper ends of their ranges (asked {:.3g}): error {:.3g}, time {:.3g}",
                  std::exp(tally.log_error / n), std::exp(tally.log_time / n), Wish{}.level,
                  tally.errors_within / n, tally.times_within / n));
}

} // namespace

void add_choose_checks(const BenchOptions& options, const Control& control, BenchReport& report) {
  const std::clock_t start = std::clock();
  const auto seconds = [start] { return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC; };
  const auto rows = built_in_trade_table();
  const Calibration calibration(rows);
  Methods methods;
  UnseenScenes scenes(seed);
  Tally tally;
  const int wanted = options.quick ? 6 : 56;
  while (tally.promises < wanted && tally.draws < most_draws_per_promise * wanted &&
         seconds() < most_seconds &&
         goes_on(control, tally.promises / static_cast<double>(wanted), "choices on unseen scenes"))
    ask(scenes.draw(), calibration, methods, report, tally);
  add_notes(tally, report);
  const double n = std::max(tally.promises, 1);
  report.checks.push_back({"choose_error_kept", tally.errors_kept / n});
  report.checks.push_back({"choose_time_kept", tally.times_kept / n});
  report.checks.push_back({"choose_scenes", static_cast<double>(tally.promises)});
}

} // namespace maille::lab
