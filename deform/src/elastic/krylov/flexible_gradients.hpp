#pragma once
/// Conjugate gradients in float64 around a preconditioner that is not quite the same every time.

#include "elastic/krylov/coupled_error.hpp"
#include "elastic/krylov/coupled_task.hpp"
#include "elastic/krylov/elastic_operator.hpp"

#include <string>

namespace maille::deform {

/// Flexible conjugate gradients (Polak-Ribiere), which tolerate a float32 preconditioner; everything else is
/// float64. Notation: r = f - K u the residual, B the preconditioner, z = B r, p the direction. beta is r_new
/// . (z_new - z_old) / (r_old . z_old); the term r_new . z_old (`overlap`) vanishes if B is constant.
///
/// Stops when the error is below tolerance in both the energy norm and the displacement norm (Euclidean),
/// confirmed on a recomputed residual. Both are needed: slender bodies move far at little energy.
/// CoupledError estimates the energy norm from the steps.
///
/// Without progress for `patience` iterations, or without a descent direction, the residual is compared with
/// the rounding of K u (left_by_rounding): at that level the solve is finished, above it is stalled. The
/// comparison is heuristic, by a factor of 100.
///
/// Same bits for any number of threads, if the operator's are.
///
/// Source  Notay 2000, Flexible conjugate gradients, section 2
/// Checked by  tests/deform/elastic/slender/slender_boxes_test.cpp
class FlexibleGradients : private FieldGradients, private GradientWatch {
public:
  /// At most: its fields, and loads.
  static constexpr std::int64_t bytes_per_grid_node = 7 * 3 * sizeof(double);
  /// For the task's own loads, and what it fixes.
  explicit FlexibleGradients(const CoupledTask& task);
  /// For other forces and fixed components.
  FlexibleGradients(const CoupledTask& task, Loads forces, FixedMask fixed);

  /// Takes u to the answer. finished: within the tolerance, or as near as rounding lets it be; stopped: by
  /// the caller or by the number of iterations; stalled: the error does not fall, or is not finite, and
  /// problem() says so.
  CoupledRound solve(ElasticOperator& K, Displacement& u, Answer& answer);
  const std::string& problem() const { return problem_; }
  /// solve() from answer.displacement, then energy and reactions.
  /// @return as CoupledAlgorithm
  bool finish(ElasticOperator& K, Answer& answer);

private:
  std::optional<double> find_step(double beta, double product) override;
  void take_step(double step) override;
  bool goes_on() override;
  bool goes_on_from(double product) override;
  bool goes_on_after(double step, double product) override;

  void find_energy_and_reactions(ElasticOperator& K, const Displacement& u, Answer& answer);
  void find_residual();
  double estimate(double energy_of_error) const;
  bool is_stuck(double left);
  double left_by_rounding();
  bool is_at_rounding(double left);
  void end_at_rounding(double left);
  void stall(double left);

  const CoupledTask& task_;
  Loads forces_;
  CoupledError error_;
  Answer* answer_ = nullptr;
  std::int64_t last_iteration_ = 0;
  Displacement diagonal_; ///< of K, once it is needed [N/m]
  CoupledRound end_ = CoupledRound::stopped;
  bool is_to_check_ = false; ///< the estimate is within the tolerance, and the residual found anew decides
  double energy_ = 0;        ///< u . K u [N m]
  double first_error_ = 0;   ///< r . B r at the start [N m]
  double moved_ = 0;         ///< squared length of the last step [m^2]
  double length_ = 0;        ///< squared, of u [m^2]
  double best_ = 0;          ///< r . B r so far
  std::int64_t best_at_ = 0;
  std::string problem_;
};

} // namespace maille::deform
