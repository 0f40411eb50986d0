#include "bench/relax/relax.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace maille::lab {

namespace {

double nodes_of(int cells) {
  return std::pow(cells + 1.0, 3);
}

double ns_per_node(const Measured& measured, int cells) {
  return 1e9 * measured.seconds.total() / nodes_of(cells);
}

/// Without the answer in float64, which every method hands over.
double own_bytes_per_node(const Measured& measured, int cells) {
  return static_cast<double>(measured.bytes) / nodes_of(cells) - 24;
}

/// Predictions are from costs that the headers of the methods state, unless they say otherwise.
class Checks {
public:
  Checks(const RelaxSizes& sizes, const RelaxFigures& figures, BenchReport& report)
      : sizes_(sizes), figures_(figures), report_(report) {}

  void add_finite_elements();
  void add_growth();
  void add_accuracy();
  void add_bodies();
  void add_rivals();

private:
  void add(const char* name, double value, std::string predicted, std::string physical_limit = "",
           std::optional<double> goal = {}) {
    report_.checks.push_back({name, value, std::move(predicted), std::move(physical_limit), goal});
  }
  /// If the solver's own arrays crossed the memory bus once an iteration and did nothing else.
  double ns_per_node_of_memory(const Measured& measured, int cells) const {
    return own_bytes_per_node(measured, cells) * static_cast<double>(measured.iterations) / figures_.copy_one;
  }

  RelaxSizes sizes_;
  const RelaxFigures& figures_;
  BenchReport& report_;
};

void Checks::add_finite_elements() {
  const auto quickest = [&](const auto& seconds_of) {
    double least = std::numeric_limits<double>::infinity();
    for (const Measured& measured : figures_.fem_middle)
      if (measured.algebra_error <= 1e-3) // what is less exact does not count
        least = std::min(least, seconds_of(measured.seconds));
    return least / seconds_of(figures_.coupled_middle.seconds);
  };
  const std::string limit =
      fmt::format("coupled: {:.3g} ns a node if it read its arrays once an iteration; took {:.3g}",
                  ns_per_node_of_memory(figures_.coupled_middle, sizes_.middle),
                  ns_per_node(figures_.coupled_middle, sizes_.middle));
  add("fem_total_over_coupled_65", quickest([](const Seconds& s) { return s.total(); }),
      "40: deal.II's multigrid 8.1 us a node; coupled 0.2, of which 3 iterations of 35 ns, their start and "
      "residuals in float64 as much again",
      limit);
  add("fem_solve_over_coupled_65", quickest([](const Seconds& s) { return s.solve; }),
      "13: deal.II's 2.1 us a node over 0.165", limit);
}

void Checks::add_growth() {
  const Measured &small = figures_.coupled_small, &large = figures_.coupled_large;
  add("ns_per_node_129_over_33", ns_per_node(large, sizes_.large) / ns_per_node(small, sizes_.small),
      "1.2: as many iterations; the small box stays in the cache",
      fmt::format("1 if neither were held up by memory; {:.3g} ns a node large, {:.3g} small, {:.3g} at the "
                  "copy's rate",
                  ns_per_node(large, sizes_.large), ns_per_node(small, sizes_.small),
                  ns_per_node_of_memory(large, sizes_.large)));
  add("relaxed_over_coupled_129", figures_.relaxed_large.seconds.total() / large.seconds.total(),
      "0.4 to 0.5: 35 to 45 ns a node over 90", "");
  add("bytes_per_node_coupled", own_bytes_per_node(large, sizes_.large),
      "36 to 76: 60 to 100 of the header, if they hold the answer's 24 (not counted here)",
      "36: three components of residual, direction and image in float32");
  add("two_threads_speedup", large.seconds.total() / figures_.coupled_large_two_threads.seconds.total(),
      "1.65, as relaxed",
      fmt::format("2 where the cache keeps up; copies gain {:.2f}", figures_.copy_all / figures_.copy_one));
}

void Checks::add_accuracy() {
  const auto over_edge = [](const Measured& fine, double ratio) {
    return fmt::format("{:.3g}: order 1 at the edges of what is prescribed, from the middle lattice",
                       *fine.error * ratio);
  };
  add("q1_error_over_coupled_nu49_65", *figures_.q1_nu49.error / *figures_.coupled_nu49.error,
      "4.3: 17.8 % over 4.1 % on 16 x 16 x 8 cells");
  add("poke_error_32", *figures_.extrapolated_small.error,
      "0.0187 of the answer extrapolated from nested lattices: 1.69 % of 3.15 % on 16^3",
      fmt::format("of the lattice alone: {:.3g}; {}", *figures_.coupled_small.error,
                  over_edge(figures_.coupled_middle, static_cast<double>(sizes_.middle) / sizes_.small)));
  add("pull_error_16", *figures_.coupled_pull.error,
      over_edge(figures_.stretch_middle, static_cast<double>(sizes_.middle) / sizes_.pull));
}

void Checks::add_bodies() {
  add("limits_active_over_elastic_65", figures_.limits_active_over_elastic,
      "5: on each box a few truncated Newton steps, each of which costs what an elastic answer does to a "
      "tenth, and finds the forces and the active links anew; 2 for the nearest feasible state alone",
      "0.4: the start on coarser grids shows whether limits bind, a direction whether anything is left");
  add("default_over_wide_box_65", figures_.default_over_wide,
      "0.95: without limits there is nothing to look for, to permit or to compare with");
  // The box's start on coarser grids, which other bodies do without, spares it an iteration or two for the
  // price of half of one.
  const auto box = static_cast<double>(figures_.stretch_middle.iterations + 1);
  add("iterations_muscle_over_box", static_cast<double>(figures_.muscle_iterations) / box,
      "2.5: 10 on the soleus with coarser bodies whose pieces stay apart, over 4 (" + figures_.muscle +
          " over the stretched box, nu 0.3, whose start on coarser grids counts as one)",
      "1");
  if (figures_.leg_iterations)
    add("iterations_leg_over_box", static_cast<double>(*figures_.leg_iterations) / box,
        "6: 23 to 1e-3 with coarser bodies whose pieces stay apart, over 4", "1");
}

void Checks::add_rivals() {
  const RivalFigures& rivals = figures_.rivals;
  const std::string limit =
      fmt::format("coupled's own error, {:.3g}; a rival's loss is larger", rivals.coupled_error);
  add("xpbd_error_at_equal_time", rivals.xpbd_error,
      "near 1: 6 iterations a node along a side at 14 ns a node would take 15 times as long to 1 %", limit,
      rivals.coupled_error);
  if (rivals.bullet_error)
    add("bullet_error_at_equal_time", *rivals.bullet_error,
        "near 1: a step of ten iterations at a node's 13 links has hardly begun", limit,
        rivals.coupled_error);
}

} // namespace

void add_relax_checks(const RelaxSizes& sizes, const RelaxFigures& figures, BenchReport& report) {
  Checks checks(sizes, figures, report);
  checks.add_finite_elements();
  checks.add_growth();
  checks.add_accuracy();
  checks.add_bodies();
  checks.add_rivals();
}

} // namespace maille::lab
