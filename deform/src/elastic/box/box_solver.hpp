#pragma once
/// Linear elasticity on a box of one material: the fast case of MaskedSolver.
///
/// The same scheme (MixedSolver: float64 residuals, float32 corrections around one multigrid cycle), but
/// all cells are alike: the operator is a stencil without stored coefficients, and coarse grids are boxes
/// again. The solve begins with the optimum on coarser grids (full multigrid).
///
/// For tolerances of 5e-4 and more, the state itself is float32 in the first round ("whole" state: the fields
/// hold u, not a change of u).

#include "elastic/box/box_system.hpp"
#include "elastic/krylov/kept_body.hpp"
#include "elastic/krylov/mixed_solver.hpp"

#include <memory>
#include <vector>

namespace maille::deform {

/// Cached set-up of a box: operator and hierarchy for the fixed components.
class BoxBody : public KeptHierarchy {
public:
  /// @param scene its matter counts @param team must outlive this
  BoxBody(const Scene& scene, const std::vector<Prescribed>& prescribed, ThreadTeam& team);
  bool is_made_for(const FixedMask& fixed) const { return fixed == fixed_; }
  bool adopt_materials(double) override { return false; } // it is made in less than an iteration's time

  double unit = 1; ///< of forces per displacement [N/m]
  std::unique_ptr<BoxMultigrid> multigrid;
  std::unique_ptr<BoxGradients> fields;
  double smallest_eigenvalue = 0; ///< of the preconditioned operator, as it was met; 0: not yet

private:
  FixedMask fixed_;
};

/// Same bits for any number of threads.
class BoxSolver : public MixedSolver {
public:
  /// @pre is_uniform_box(task.scene)
  explicit BoxSolver(const CoupledTask& task);

  const char* algorithm() const override {
    return "lattice elasticity, conjugate gradients around lattice multigrid";
  }
  BoxSystem& system() override { return system_; }
  BoxSystem& system_of_slender() override {
    system_.resolve_bending();
    return system_;
  }
  CoupledRound solve(Displacement& u, Answer& answer) override;
  void find_energy_and_reactions(const Displacement& u, Answer& answer) override;

private:
  void begin_on_coarser_grids(Displacement& u);
  GradientSpace& space() override { return *body_.fields; }
  Residual begin_round(const Displacement& u, double scale) override;
  double work_of_loads() override;
  void finish_round(Displacement& u, CoupledRound end) override;
  double residual_of_plane(const Displacement& u, int z, double scale, double& largest);
  double work_from_residual(const Displacement& u, int z) const;

  static BoxBody& body_of(const CoupledTask& task, std::unique_ptr<BoxBody>& own);

  std::unique_ptr<BoxBody> own_; ///< where nothing is kept
  BoxBody& body_;
  BoxSystem system_;
  /// u . r per plane in units of unit_, of a round whose state is the whole displacement [m^2].
  std::vector<double> work_of_residual_;
};

} // namespace maille::deform
