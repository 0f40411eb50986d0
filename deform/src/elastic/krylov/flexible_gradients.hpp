#pragma once
/// Conjugate gradients in float64 around a preconditioner that is not quite the same every time.

#include "elastic/krylov/conjugate_gradients.hpp"
#include "elastic/krylov/coupled_error.hpp"
#include "elastic/krylov/coupled_system.hpp"
#include "elastic/krylov/coupled_task.hpp"
#include "elastic/krylov/field_sums.hpp"

#include "maille/scene/arena.hpp"

#include <string>
#include <vector>

namespace maille::deform {

/// [component][node], of three components: prescribed, or none of the body's.
std::vector<std::vector<bool>> fixed_components(const CoupledTask& task);

/// Operator and preconditioner of flexible conjugate gradients; all fields dense, [component][node].
class FlexibleOperator {
public:
  virtual ~FlexibleOperator() = default;
  /// forces = K u, everywhere [N].
  virtual void apply(const Displacement& u, Displacement& forces) = 0;
  /// correction = about K^-1 residual where components are free, 0 elsewhere [m].
  virtual void precondition(const Displacement& residual, Displacement& correction) = 0;
  /// Diagonal of K [N/m]; called only where the residual stagnates.
  virtual Displacement diagonal() const = 0;
};

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
class FlexibleGradients : private GradientSpace, private GradientWatch {
public:
  /// At most: its fields, and loads.
  static constexpr std::int64_t bytes_per_grid_node = 7 * 3 * sizeof(double);
  /// @param forces   of loads [component][node], empty where there are none [N]
  /// @param is_fixed [component][node]
  FlexibleGradients(const CoupledTask& task, std::vector<List<double>> forces,
                    std::vector<std::vector<bool>> is_fixed);

  /// Takes u to the answer. finished: within the tolerance, or as near as rounding lets it be; stopped: by
  /// the caller or by the number of iterations; stalled: the error does not fall, or is not finite, and
  /// problem() says so.
  CoupledRound solve(FlexibleOperator& K, Displacement& u, Answer& answer);
  const std::string& problem() const { return problem_; }
  /// solve(), then all that a way of `coupled` owes: energy and reactions, and limits.
  /// @return as CoupledAlgorithm
  bool finish(FlexibleOperator& K, CoupledSystem& system, Answer& answer);
  bool is_fixed(std::size_t component, std::size_t node) const { return is_fixed_[component][node]; }
  /// Energy, and what holds every prescribed component of the scene there.
  void find_energy_and_reactions(FlexibleOperator& K, const Displacement& u, Answer& answer);

private:
  double precondition() override;
  std::optional<double> find_step(double beta, double product) override;
  void take_step(double step) override;
  double overlap() const override { return overlap_; }
  bool goes_on() override;
  bool goes_on_from(double product) override;
  bool goes_on_after(double step, double product) override;

  void find_residual();
  double estimate(double energy_of_error) const;
  bool is_stuck(double left);
  double left_by_rounding();
  bool is_at_rounding(double left);
  void end_at_rounding(double left);
  void stall(double left);

  const CoupledTask& task_;
  std::vector<List<double>> forces_;
  std::vector<std::vector<bool>> is_fixed_;
  Displacement residual_, correction_, direction_, image_;
  FieldSums sums_; ///< plane by plane across the last axis
  CoupledError error_;
  FlexibleOperator* K_ = nullptr; ///< of solve(), as the next two
  Displacement* u_ = nullptr;
  Answer* answer_ = nullptr;
  CoupledRound end_ = CoupledRound::stopped;
  bool is_to_check_ = false; ///< the estimate is within the tolerance, and the residual found anew decides
  double energy_ = 0;        ///< u . K u [N m]
  double first_error_ = 0;   ///< r . B r at the start [N m]
  double curvature_ = 0;     ///< p . K p [N m]
  double overlap_ = 0;       ///< of the new residual with the correction for the one before [N m]
  double moved_ = 0;         ///< squared length of the last step [m^2]
  double length_ = 0;        ///< squared, of u [m^2]
  double best_ = 0;          ///< r . B r so far
  std::int64_t best_at_ = 0;
  std::string problem_;
};

/// For the task's own loads and what it fixes.
FlexibleGradients flexible_gradients(const CoupledTask& task);

} // namespace maille::deform
