#pragma once
/// Linear elasticity on a box of one material: the fast case of MaskedSolver.
///
/// The same scheme (MixedGradients: float64 residuals, float32 corrections around one multigrid cycle), but
/// all cells are alike: the operator is a stencil without stored coefficients, and coarse grids are boxes
/// again. The solve begins with the optimum on coarser grids (full multigrid).
///
/// For tolerances of 5e-4 and more, the state itself is float32 in the first round ("whole" state: the fields
/// hold u, not a change of u).
///
/// If limits are to be obeyed and the start breaks them clearly, solve() ends at the start (is_start_only):
/// the constrained minimum begins on coarser bodies and does not need the elastic answer.

#include "elastic/box/box_system.hpp"
#include "elastic/krylov/kept_body.hpp"
#include "elastic/krylov/mixed_gradients.hpp"

#include <memory>
#include <vector>

namespace maille::deform {

/// Cached set-up of a box: operator and hierarchy for the fixed components.
class BoxBody : public KeptHierarchy {
public:
  /// @param scene its matter counts @param team must outlive this
  BoxBody(const Scene& scene, const std::vector<Prescribed>& prescribed, ThreadTeam& team);
  /// Whether it is one for these, and then with no penalties.
  bool take_fixed(const std::vector<Prescribed>& prescribed);
  bool take_materials(double) override { return false; } // it is made in less than an iteration's time

  double unit = 1; ///< of forces per displacement [N/m]
  std::unique_ptr<BoxMultigrid> multigrid;
  std::unique_ptr<BoxGradients> fields;
  double smallest_eigenvalue = 0; ///< of the preconditioned operator, as it was met; 0: not yet

private:
  std::vector<FixedComponent> fixed_;
};

/// Same bits for any number of threads.
class BoxSolver : private MixedState {
public:
  /// @pre is_uniform_box(task.scene)
  explicit BoxSolver(const CoupledTask& task);

  /// Solves for u, whose prescribed components are set, unless stopped or stalled.
  CoupledRound solve(Displacement& u, Answer& answer);
  /// True if the solve ended at the start because the start breaks limits so clearly that the elastic answer
  /// is not needed.
  bool is_start_only() const { return is_start_only_; }
  /// Energy, and what holds every prescribed component of the scene there.
  void find_energy_and_reactions(const Displacement& u, Answer& answer);
  /// correction = B residual, B one multigrid cycle from nothing: symmetric and positive definite where
  /// components are free, zero where they are fixed, but for rounding to float32. Dense, [N] and [m].
  void precondition(const Displacement& residual, Displacement& correction);
  BoxMultigrid& multigrid() { return *body_.multigrid; }
  /// Unit of forces per displacement in the multigrid [N/m].
  double unit() const { return body_.unit; }

private:
  void begin_on_coarser_grids(Displacement& u);
  Residual begin_round(const Displacement& u, double scale) override;
  double work_of_loads() override;
  void finish_round(Displacement& u, bool is_last) override;
  bool is_start_enough(Displacement& u);
  double residual_of_plane(const Displacement& u, int z, double scale, double& largest);
  double work_from_residual(const Displacement& u, int z) const;

  static BoxBody& body_of(const CoupledTask& task, std::unique_ptr<BoxBody>& own);

  const CoupledTask& task_;
  std::unique_ptr<BoxBody> own_; ///< where nothing is kept
  BoxBody& body_;
  Loads loads_;
  std::unique_ptr<MixedGradients> gradients_;
  bool is_start_only_ = false; ///< see is_start_only()
  /// u . r per plane in units of unit_, of a round whose state is the whole displacement [m^2].
  std::vector<double> work_of_residual_;
};

} // namespace maille::deform
