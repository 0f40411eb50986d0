#pragma once
/// Conjugate gradients in float64 around a preconditioner that is not quite the same every time.
///
/// Flexible conjugate gradients (Polak-Ribiere), which tolerate a float32 preconditioner; everything else is
/// float64. Notation: r = f - K u the residual, B the preconditioner, z = B r, p the direction. beta is r_new
/// . (z_new - z_old) / (r_old . z_old); the term r_new . z_old (`overlap`) vanishes if B is constant.
///
/// Convergence decides when it ends: both norms of the error are within the tolerance, since slender bodies
/// move far at little energy; or the residual is at the level of its rounding (product_of_rounding).
///
/// Same bits for any number of threads, if the operator's are.
///
/// Source  Notay 2000, Flexible conjugate gradients, section 2
/// Checked by  tests/deform/elastic/slender/slender_boxes_test.cpp

#include "elastic/krylov/convergence.hpp"
#include "elastic/krylov/coupled_task.hpp"
#include "elastic/krylov/elastic_operator.hpp"

#include <string>

namespace maille::deform {

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
  bool should_continue() override;
  bool should_continue_from(double product) override;
  bool should_continue_after(double step, double product) override;

  void find_energy_and_reactions(ElasticOperator& K, const Displacement& u, Answer& answer);
  void find_residual();
  double product_of_rounding();
  void end(Convergence::End end);
  Convergence::State state() const { return {energy_, moved_, length_}; }

  const CoupledTask& task_;
  Loads forces_;
  Convergence convergence_;
  Answer* answer_ = nullptr;
  std::int64_t last_iteration_ = 0;
  Displacement diagonal_; ///< of K, once it is needed [N/m]
  CoupledRound end_ = CoupledRound::stopped;
  double energy_ = 0; ///< u . K u [N m]
  double moved_ = 0;  ///< squared length of the last step [m^2]
  double length_ = 0; ///< squared, of u [m^2]
  std::string problem_;
};

} // namespace maille::deform
