#include "trade/trade.hpp"

#include "compare/comparison.hpp"
#include "compare/methods.hpp"
#include "maille/deform/solve.hpp"
#include "trade/measure.hpp"
#include "trade/probes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace maille::studies {

namespace {

/// Tolerances of the conjugate gradients of finite elements: where a picture stops changing, and the default.
constexpr std::array<double, 2> fem_tolerances{1e-10, 1e-4};
/// Rows that take longer are measured once.
constexpr double long_row_seconds = 1;

/// Every way, in the order of the rows.
std::vector<Way> all_ways(const TradeSettings& settings) {
  std::vector<int> halvings = settings.halvings;
  std::ranges::sort(halvings);
  std::vector<Way> ways;
  for (const std::string& method : settings.methods)
    for (const int level : halvings)
      if (has_tolerance(method))
        for (const double tolerance : settings.tolerances)
          ways.push_back({method, level, tolerance});
      else if (is_finite_elements(method))
        for (const double tolerance : fem_tolerances)
          ways.push_back({method, level, tolerance});
      else
        ways.push_back({method, level, {}});
  return ways;
}

/// Measures the ways of one scene.
class Measurement {
public:
  Measurement(Lattices& lattices, const TradeSettings& settings, const Control& control)
      : lattices_(lattices), control_(control) {
    trade_.settings = settings;
    trade_.threads = control.threads;
  }

  Trade run() {
    report(0, "reference " + trade_.settings.reference);
    solve_reference();
    if (is_converged(trade_.reference_status) && !control_.should_stop()) {
      probes_ = probe(lattices_, quiet(), false);
      measure_all();
    }
    trade_.is_whole = is_converged(trade_.reference_status) && !control_.should_stop();
    return std::move(trade_);
  }

private:
  void report(double part, const std::string& what) const {
    if (control_.progress)
      control_.progress(part, what);
  }
  /// Progress is that of the whole.
  Control quiet() const {
    Control control = control_;
    control.progress = nullptr;
    return control;
  }

  void solve_reference() {
    Methods methods;
    BestReference best;
    if (trade_.settings.reference == "best")
      best = best_reference(lattices_.scene(), trade_.settings.reference_seconds, quiet(), methods);
    else
      best.answer = methods.answer(lattices_.scene(), trade_.settings.reference, quiet());
    trade_.reference_algorithm = best.answer.algorithm;
    trade_.reference_status = best.answer.status;
    trade_.reference_message = best.answer.message;
    trade_.reference_seconds = best.answer.seconds;
    trade_.reference_error = best.estimated_error;
    if (is_converged(best.answer.status) && !lattices_.measures().empty())
      wanted_ = measured_answer(lattices_.scene(), lattices_.measures(), best.answer);
    reference_ = std::move(best.answer.displacement);
  }

  /// Measures of the answer, each on the row's own lattice.
  std::vector<MeasureRow> measures_of(const TradeRow& row, const LatticeScene& lattice,
                                      const Answer& answer) const {
    if (!has_displacement(answer.status) || !lattice.measures)
      return without_values(lattices_.measures(), lattices_.scene().dimension(),
                            has_displacement(answer.status) ? "no place for it on this lattice"
                                                            : std::string(to_string(answer.status)));
    return with_errors(measured_answer(*lattice.scene, *lattice.measures, answer),
                       is_the_reference(row.way) ? std::vector<MeasuredValue>() : wanted_);
  }

  void measure_all() {
    const std::vector<Way> ways = all_ways(trade_.settings);
    for (std::size_t i = 0; i < ways.size() && !control_.should_stop(); ++i) {
      const Way& way = ways[i];
      report(static_cast<double>(i) / static_cast<double>(ways.size()),
             fmt::format("{} at {:g} times the spacing", way.method, std::exp2(-way.halvings)));
      if (!is_second_tolerance_of_a_factor(way))
        add_row(way);
    }
    for (int turn = 1; turn < trade_.settings.repetitions; ++turn)
      for (std::size_t i = 0; i < trade_.rows.size() && !control_.should_stop(); ++i) {
        report(static_cast<double>(i) / static_cast<double>(trade_.rows.size()),
               fmt::format("repetition {} of {}", turn + 1, trade_.settings.repetitions));
        repeat(i);
      }
    for (std::size_t i = 0; i < trade_.rows.size(); ++i)
      take_medians(i);
  }

  /// A factor knows no tolerance: what was solved without iterations is not asked again.
  bool is_second_tolerance_of_a_factor(const Way& way) const {
    if (trade_.rows.empty() || !is_finite_elements(way.method) || way.tolerance == fem_tolerances.front())
      return false;
    const TradeRow& last = trade_.rows.back();
    return last.way.method == way.method && last.way.halvings == way.halvings &&
           (last.iterations == 0 || !has_displacement(last.status) ||
            lattices_.scene().strain == Strain::finite); // its iterations are Newton steps
  }

  /// Its error would be that of the algebra alone.
  bool is_the_reference(const Way& way) const {
    const bool is_same_method =
        way.method == trade_.settings.reference ||
        (trade_.settings.reference == "best" && trade_.reference_algorithm.starts_with(way.method + ": "));
    return is_same_method && way.halvings == 0;
  }

  /// Why finite elements are not tried; empty where they are.
  std::string why_too_much(const Way& way, const Scene& scene) const {
    if (!is_finite_elements(way.method))
      return {};
    fem_ref::Options options;
    options.degree = way.method == "fem_q2" ? 2 : 1;
    const fem_ref::Estimate estimate = fem_ref::estimate(scene, options);
    if (estimate.seconds <= trade_.settings.row_seconds)
      return {};
    return fmt::format("not tried: expected to take {:.0f} s", estimate.seconds);
  }

  Control row_control() const {
    Control control = quiet();
    control.seconds_budget = trade_.settings.row_seconds;
    return control;
  }

  void add_row(const Way& way) {
    TradeRow row;
    row.way = way;
    const LatticeScene lattice = lattices_.at(way.halvings);
    row.status = Status::refused;
    row.message = lattice.why_not;
    if (lattice.scene) {
      row.cells = lattice.scene->specimen.grid.cells();
      row.spacing = lattice.scene->specimen.grid.spacing();
      row.nodes = lattice.scene->specimen.n_matter_nodes();
      row.message = why_too_much(way, *lattice.scene);
      if (row.message.empty())
        fill(row, lattice);
    }
    if (row.measures.empty())
      row.measures = without_values(lattices_.measures(), lattices_.scene().dimension(), "no answer");
    trade_.rows.push_back(std::move(row));
    runs_.resize(trade_.rows.size());
  }

  void fill(TradeRow& row, const LatticeScene& lattice) {
    const Scene& scene = *lattice.scene;
    const Measured run = measure(scene, row.way.method, row.way.tolerance, row_control());
    const Answer& answer = run.answer;
    row.status = answer.status;
    row.algorithm = answer.algorithm;
    row.message = answer.message;
    row.bytes = answer.bytes;
    row.iterations = answer.iterations;
    row.predicted = predict_raw(probes_, row.way, &scene, row.nodes);
    if (has_displacement(answer.status) && !is_the_reference(row.way))
      row.error = compare(lattices_.scene(), between_lattices(scene, answer.displacement, lattices_.scene()),
                          reference_);
    if (!lattices_.measures().empty())
      row.measures = measures_of(row, lattice, answer);
    runs_.resize(trade_.rows.size() + 1);
    runs_.back().push_back({answer.seconds, run.wall_seconds});
  }

  void repeat(std::size_t i) {
    const TradeRow& row = trade_.rows[i];
    if (!is_converged(row.status) || runs_[i].front().wall > long_row_seconds)
      return;
    const Measured run =
        measure(*lattices_.at(row.way.halvings).scene, row.way.method, row.way.tolerance, row_control());
    if (is_converged(run.answer.status))
      runs_[i].push_back({run.answer.seconds, run.wall_seconds});
  }

  void take_medians(std::size_t i) {
    std::vector<double> setup, solve, wall;
    for (const Run& run : runs_[i]) {
      setup.push_back(run.seconds.setup);
      solve.push_back(run.seconds.solve);
      wall.push_back(run.wall);
    }
    TradeRow& row = trade_.rows[i];
    row.repetitions = static_cast<int>(wall.size());
    if (wall.empty())
      return;
    row.seconds = {median(setup), median(solve)};
    row.wall_seconds = median(wall);
  }

  struct Run {
    Seconds seconds;
    double wall = 0;
  };

  Lattices& lattices_;
  const Control& control_;
  Trade trade_;
  Displacement reference_;
  std::vector<MeasuredValue> wanted_; ///< the reference's measures
  Probes probes_;
  std::vector<std::vector<Run>> runs_; ///< of every row
};

} // namespace

std::vector<std::string> default_trade_methods() {
  std::vector<std::string> methods = all_methods();
  std::erase_if(methods, [](const std::string& name) { return name == "dijkstra" || name == "calculix"; });
  return methods;
}

bool Trade::any_failed() const {
  return !is_whole || std::ranges::any_of(rows, [](const TradeRow& row) {
    return row.status == Status::failed || row.status == Status::interrupted;
  });
}

Trade measure_trade(Lattices& lattices, const TradeSettings& settings, const Control& control) {
  TradeSettings with_methods = settings;
  if (with_methods.methods.empty())
    with_methods.methods = default_trade_methods();
  return Measurement(lattices, with_methods, control).run();
}

} // namespace maille::studies
