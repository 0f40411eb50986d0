#pragma once
/// The search for the best numbers of a fit.
///
/// NLopt and not Ceres: an answer of `limits` consists of minima over paths, so errors have kinks where the
/// shortest path changes, a wall where limits begin to cut moves back (the best limits of a pulled bar lie
/// right at it), and no known derivatives. That requires derivative-free methods, which NLopt has, global and
/// local ones.

#include "fit/parameters.hpp"

namespace maille::studies {

class FitSearch {
public:
  FitSearch(std::span<const FitCase> cases, const FitParameters& parameters, std::string method,
            const Control& control);

  /// Searches from `start`, in at most `evaluations` evaluations.
  /// @throws std::runtime_error where the method refuses a scene
  void run(const std::vector<double>& start, int evaluations);
  /// done, budget_reached or interrupted
  Status status() const { return status_; }
  int evaluations() const { return evaluations_; }
  const std::vector<double>& best() const { return best_; }
  /// Mean of squares at the best point.
  double best_value() const { return best_value_; }
  /// False where no limits were found that let every move through.
  bool is_feasible() const { return is_feasible_; }
  /// The value of any numbers; remembers them where they are the best so far. Infeasible ones pay for what
  /// they cut.
  double evaluate(const std::vector<double>& x);

private:
  void let_moves_through(std::vector<double> x);
  void search_globally(const std::vector<std::size_t>& block);
  void search_from_elsewhere(const std::vector<std::size_t>& block);
  void search_locally(double first_step);
  void minimise(int algorithm, const std::vector<std::size_t>& block, const std::vector<double>& from,
                int evaluations, double tolerance, double first_step);
  static double objective(const std::vector<double>& part, std::vector<double>& gradient, void* task);
  bool is_over();
  void report();

  std::span<const FitCase> cases_;
  const FitParameters& parameters_;
  std::string method_;
  const Control& control_;
  Control of_methods_; ///< without progress: theirs is not the fit's
  Status status_ = Status::done;
  int evaluations_ = 0, budget_ = 0;
  std::vector<double> best_;
  double best_value_ = 0;
  bool is_feasible_ = false;
};

} // namespace maille::studies
