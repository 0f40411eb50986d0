#pragma once
/// The least elastic energy within the limits of the links: last step of every algorithm of `coupled`.
///
/// Minimises 1/2 u . K u - f . u subject to low <= D u <= high, where D u are the stretches of the links.
/// Augmented Lagrangian: each link l that was ever outside its range has a multiplier y_l and the term rho
/// w_l / 2 (v - z)^2, with v = D u + y and z = v clamped to the range (ActiveLinks). For fixed y the function
/// is convex and piecewise quadratic; `gap` is the sum of w (D u - z)^2, `penalties` are the stiffnesses rho
/// w of the active links.
///
/// Algorithm: conjugate gradients around the operator's preconditioner, which knows the penalties, with an
/// exact line search (best_step). They begin anew whenever multipliers or penalties change. Multipliers
/// improve once better ones help more than better displacements (Nearness).
///
/// start_from_coarser() takes start and multipliers from the body with every second node.
/// solve_within_limits() is the entry: it also projects the result to the nearest feasible state.
///
/// Exact: the limits, after that projection; the line search, to 5 % of its first slope. Heuristic: the
/// penalties rho, the rules for when to improve multipliers, and the error estimate (Nearness).

#include "elastic/krylov/conjugate_gradients.hpp"
#include "elastic/krylov/coupled_task.hpp"
#include "elastic/krylov/elastic_operator.hpp"
#include "elastic/limits/active_links.hpp"

#include <utility>
#include <vector>

namespace maille::deform {

/// See the top of the file. Starts at the elastic answer. A link whose limits are one number needs no special
/// case.
///
/// Same bits for any number of threads.
///
/// Source  Bertsekas 1982, Constrained Optimization and Lagrange Multiplier Methods, chapter 3; Nocedal and
///         Wright 2006, section 7.1; docs/theory.md, sections 2 and 7
/// Checked by  coupled_limits_test.cpp, relaxed_test.cpp
class ConstrainedMinimum : private FieldGradients, private GradientWatch {
public:
  /// All but `components` and `loads` must outlive this. @param components that are solved for, one or all;
  /// fields have no others @param moduli whose links weigh as the penalties do @param stiffer factor on the
  /// penalties, for a K that is not of these links. @pre task.limits
  ConstrainedMinimum(const CoupledTask& task, PenalizedOperator& system, const CellModuli& moduli,
                     const std::vector<int>& components, Loads loads, double stiffer = 1);

  /// Changes `u`, which holds the prescribed values, and adds to the answer's iterations.
  /// @param error_tolerance of error()
  /// @return false if stopped
  bool solve(Displacement& u, double error_tolerance, Answer& answer);
  /// Begins with the multipliers of the same body on every second node.
  void begin_with(const ConstrainedMinimum& coarse);
  /// Begins with those of an earlier answer for the same body.
  void begin_with(const List<KeptMultiplier>& multipliers);
  List<KeptMultiplier> multipliers() const;
  /// Estimated, in the energy norm, over the answer's.
  double error() const { return error_; }
  /// Releases the memory of a field after the last solve.
  Displacement release_residual() { return std::move(residual_); }
  /// Adds the forces of the limits at every node [N].
  void add_forces_of_limits(Displacement& forces) const;
  std::size_t n_active() const;

private:
  std::optional<double> find_step(double beta, double product) override;
  void take_step(double step) override;
  bool should_continue() override;
  bool should_continue_from(double product) override;
  bool should_continue_after(double step, double product) override;

  void find_residual();
  /// Passes the active links to the operator, if more than a few changed since the last call.
  void update_penalties();
  bool are_penalties_out_of_date() const;
  double best_step(double slope, double curvature) const;
  double gap() const;
  void update_forces();
  /// The same for an unchanged state, in which no further link can become active.
  void update_forces_of_known();
  void improve_multipliers();

  const CoupledTask& task_;
  PenalizedOperator& system_;
  std::vector<List<double>> loads_; ///< per component [N]; empty: none along it
  double tolerance_ = 0;
  std::vector<ActiveLinks> links_; ///< likewise
  List<PenaltyLink> penalties_;
  bool has_penalties_ = false;
  double rounding_ = 0; ///< links outside by less are within [m]
  double energy_ = 0;   ///< u . K u [J]
  double error_ = 1;
  double slope_ = 0; ///< of the energy along the direction, without the forces of the limits [J]
  double gap_ = 0;   ///< before the step
  Answer* answer_ = nullptr;
  std::int64_t last_iteration_ = 0;
  std::optional<bool> is_found_; ///< set when conjugate gradients end
};

/// Sets `u` to the interpolated minimum of the coarser body, found recursively, and passes its multipliers to
/// `minimum`. Active links and their forces are found there at an eighth of the cost. Differences of moves,
/// materials and holes on the coarser body cost iterations, not accuracy.
/// @param u holds the prescribed values, and keeps them
/// @return  false, and nothing changes, if an axis has an odd number of cells or too few, if the holds of the
/// coarser body leave a rigid motion, or if it was stopped
bool start_from_coarser(const CoupledTask& task, ConstrainedMinimum& minimum, Displacement& u);

/// The elastic answer; if it breaks the task's limits, the least energy within them (see ConstrainedMinimum)
/// and then the nearest feasible state. Strain energy, residual, reactions and message of the answer are
/// those of that state. An answer that was cut short is projected without a search.
CoupledAlgorithm solve_within_limits;

} // namespace maille::deform
