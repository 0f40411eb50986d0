#pragma once
/// Elasticity on a box of one material, solved.

#include "elastic/box/box_multigrid.hpp"
#include "elastic/krylov/coupled_task.hpp"

#include <array>
#include <vector>

namespace maille::deform {

/// Conjugate gradients in float32 around one multigrid cycle, for corrections of a state in float64.
/// Residuals are carried along for five digits, then found anew in float64; so errors go down as far as
/// float64 lets them. Where a tolerance of 5e-4 or more is asked, the state itself is in float32 for those
/// five digits.
///
/// Same bits for any number of threads.
class BoxSolver {
public:
  /// @pre is_uniform_box(task.scene)
  explicit BoxSolver(const CoupledTask& task);

  /// Takes u, in which prescribed components have their values, to the answer, if it is not stopped and does
  /// not stall.
  CoupledRound solve(Displacement& u, Answer& answer);
  /// Whether that ended at the start, because it breaks limits so clearly that nobody needs the elastic
  /// answer.
  bool is_start_only() const { return is_start_only_; }
  /// Energy, and what holds every prescribed component of the scene there.
  void find_energy_and_reactions(const Displacement& u, Answer& answer);
  /// correction = B residual, B one multigrid cycle from nothing: symmetric and positive definite where
  /// components are free, zero where they are fixed, but for rounding to float32. Dense, [N] and [m].
  void precondition(const Displacement& residual, Displacement& correction);
  BoxMultigrid& multigrid() { return *multigrid_; }
  /// Of forces per displacement in the multigrid [N/m].
  double unit() const { return unit_; }
  std::int64_t bytes() const;

private:
  using Round = CoupledRound;

  void begin_on_coarser_grids(Displacement& u);
  void choose_scale();
  Round correct(Displacement& u, Answer& answer);
  void begin_round(const Displacement& u);
  Round iterate(Answer& answer);
  void finish_round(Displacement& u);
  bool is_start_enough(Displacement& u);
  double find_residual(const Displacement& u);
  double residual_of_plane(const Displacement& u, int z, double& largest);
  double work_of_forces(const float* direction);
  double work_from_residual(const Displacement& u, int z) const;

  const CoupledTask& task_;
  double unit_ = 1;                          ///< of forces per displacement [N/m]
  std::array<std::vector<double>, 3> loads_; ///< [N]; empty: none along that component
  std::unique_ptr<BoxMultigrid> multigrid_;
  PaddedArray direction_;
  PaddedArray state_;          ///< of the round, in units of scale_
  bool is_whole_ = false;      ///< that is all of the displacement, not a change of it
  bool is_start_only_ = false; ///< see is_start_only()
  BoxSteps steps_;             ///< not taken yet
  double scale_ = 1;           ///< residuals are counted in this times unit_ [m]
  double next_scale_ = 1;      ///< of the next round
  double energy_ = 0;          ///< u . K u in units of unit_ [m^2]
  double round_began_ = 0;     ///< r . z of the last round [m^2]
  std::vector<double>
      work_of_residual_;   ///< u . r per plane in units of unit_, of a round whose state is whole [m^2]
  double first_began_ = 0; ///< of the first
  CoupledError error_;
  std::int64_t bytes_of_start_ = 0;
};

} // namespace maille::deform
