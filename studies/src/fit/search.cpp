#include "fit/search.hpp"

#include <fmt/format.h>
#include <nlopt.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace maille::studies {

namespace {

constexpr unsigned long seed = 20250607; ///< any; the same in every run
/// What a move that is cut back wholly adds to the mean of squares, whose worst is about 1: an exact penalty.
constexpr double price_of_a_cut = 10;
constexpr int most_doublings = 12;
constexpr int fresh_starts = 12, evaluations_of_a_start = 40; ///< the latter a number
constexpr int global_evaluations_a_number = 150, local_evaluations_a_number = 400;
constexpr double global_tolerance = 1e-3, local_tolerance = 1e-8; ///< of logarithms

/// What NLopt hands to the objective.
struct Task {
  FitSearch* search;
  const std::vector<std::size_t>* block;
  std::vector<double> whole; ///< numbers outside of the block stay as they are here
};

} // namespace

FitSearch::FitSearch(std::span<const FitCase> cases, const FitParameters& parameters, std::string method,
                     const Control& control)
    : cases_(cases), parameters_(parameters), method_(std::move(method)), control_(control),
      best_value_(std::numeric_limits<double>::infinity()) {
  of_methods_.threads = control.threads;
  of_methods_.stop_requested = control.stop_requested;
}

bool FitSearch::is_over() {
  if (status_ == Status::done && control_.should_stop())
    status_ = Status::interrupted;
  if (status_ == Status::done && evaluations_ >= budget_)
    status_ = Status::budget_reached;
  return status_ != Status::done;
}

void FitSearch::report() {
  if (control_.progress)
    control_.progress(
        std::min(1.0, static_cast<double>(evaluations_) / budget_),
        fmt::format("of at most {} trials, error {:.4g} %", budget_, 100 * std::sqrt(best_value_)));
}

double FitSearch::evaluate(const std::vector<double>& x) {
  const std::vector<Material> materials = parameters_.materials(x);
  double sum = 0, cut = 0;
  bool is_whole = true;
  for (const FitCase& one : cases_) {
    const FitError error = fit_error(one, materials, method_, of_methods_);
    if (error.status == Status::interrupted) {
      status_ = Status::interrupted;
      return std::numeric_limits<double>::infinity(); // a state on its way says nothing
    }
    sum += error.relative_l2 * error.relative_l2;
    cut += error.cut;
    is_whole = is_whole && error.status == Status::done;
  }
  ++evaluations_;
  const double n = static_cast<double>(cases_.size());
  const double value = (sum + price_of_a_cut * cut) / n;
  if ((is_whole && !is_feasible_) || (is_whole == is_feasible_ && value < best_value_)) {
    best_ = x;
    best_value_ = value;
    is_feasible_ = is_whole;
  }
  report();
  return value;
}

double FitSearch::objective(const std::vector<double>& part, std::vector<double>&, void* data) {
  Task& task = *static_cast<Task*>(data);
  if (task.search->is_over())
    throw nlopt::forced_stop();
  for (std::size_t i = 0; i < part.size(); ++i)
    task.whole[(*task.block)[i]] = part[i];
  return task.search->evaluate(task.whole);
}

void FitSearch::minimise(int algorithm, const std::vector<std::size_t>& block,
                         const std::vector<double>& from, int evaluations, double tolerance,
                         double first_step) {
  const auto n = static_cast<unsigned>(block.size());
  std::vector<double> low(n), high(n), part(n);
  for (std::size_t i = 0; i < n; ++i) {
    low[i] = std::min(parameters_.low()[block[i]], from[block[i]]);
    high[i] = std::max(parameters_.high()[block[i]], from[block[i]]);
    part[i] = from[block[i]];
  }
  Task task{this, &block, from};
  nlopt::opt optimiser(static_cast<nlopt::algorithm>(algorithm), n);
  optimiser.set_min_objective(objective, &task);
  optimiser.set_lower_bounds(low);
  optimiser.set_upper_bounds(high);
  optimiser.set_maxeval(evaluations);
  optimiser.set_xtol_abs(tolerance);
  if (first_step > 0)
    optimiser.set_initial_step(first_step);
  double value = 0;
  try {
    optimiser.optimize(part, value);
  } catch (const nlopt::forced_stop&) { // the best is kept here
  } catch (const nlopt::roundoff_limited&) {
  }
}

void FitSearch::let_moves_through(std::vector<double> x) {
  evaluate(x);
  for (int i = 0; i < most_doublings && !is_feasible_ && !is_over(); ++i) {
    for (std::size_t k = 0; k < x.size(); ++k)
      x[k] = std::min(x[k] + std::log(2.0), parameters_.high()[k]);
    evaluate(x);
  }
}

void FitSearch::search_globally(const std::vector<std::size_t>& block) {
  nlopt::srand(seed);
  minimise(nlopt::GN_CRS2_LM, block, best_, global_evaluations_a_number * static_cast<int>(block.size()),
           global_tolerance, 0);
}

void FitSearch::search_from_elsewhere(const std::vector<std::size_t>& block) {
  std::mt19937 lot(seed);
  for (int i = 0; i < fresh_starts && !is_over(); ++i) {
    std::vector<double> from = best_;
    for (const std::size_t k : block) {
      const double part = static_cast<double>(lot()) / static_cast<double>(std::mt19937::max());
      // The range's middle half: what is rigid or free from the start has no slope to go by.
      from[k] = parameters_.low()[k] + (0.25 + part / 2) * (parameters_.high()[k] - parameters_.low()[k]);
    }
    minimise(nlopt::LN_SBPLX, block, from, evaluations_of_a_start * static_cast<int>(block.size()),
             global_tolerance, 0.5);
  }
}

void FitSearch::search_locally(double first_step) {
  for (const auto& block : parameters_.blocks())
    minimise(nlopt::LN_SBPLX, block, best_, local_evaluations_a_number * static_cast<int>(block.size()),
             local_tolerance, first_step);
}

void FitSearch::run(const std::vector<double>& start, int evaluations) {
  budget_ = evaluations;
  best_ = start;
  let_moves_through(start);
  for (const auto& block : parameters_.blocks_of_materials()) {
    search_globally(block);
    search_from_elsewhere(block);
  } // Subplex may come to rest beside a kink; a fresh simplex there finds its way on, if there is one.
  for (double step = 0.5; step > 1e-3 && !is_over(); step /= 4)
    search_locally(step);
}

} // namespace maille::studies
