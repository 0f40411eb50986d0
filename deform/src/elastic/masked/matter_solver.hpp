#pragma once
/// Elasticity on a body of any shape and any matter in 3D, solved.

#include "elastic/krylov/coupled_task.hpp"
#include "elastic/masked/matter_multigrid.hpp"

#include <array>
#include <vector>

namespace maille::deform {

/// Conjugate gradients in float32 around one multigrid cycle, for corrections of a state in float64.
/// Residuals are carried along for five digits, then found anew in float64; so errors go down as far as
/// float64 lets them.
///
/// Same bits for any number of threads.
class MatterSolver {
public:
  /// @param task of a scene in 3D
  explicit MatterSolver(const CoupledTask& task);

  /// Takes u, in which prescribed components have their values, to the answer, if it is not stopped and does
  /// not stall.
  CoupledRound solve(Displacement& u, Answer& answer);
  /// Energy, and what holds every prescribed component of the scene there.
  void find_energy_and_reactions(const Displacement& u, Answer& answer);
  /// correction = B residual, B one multigrid cycle from nothing: symmetric and positive definite where
  /// components are free, zero where they are fixed, but for rounding to float32. Dense, [N] and [m].
  void precondition(const Displacement& residual, Displacement& correction);
  MatterMultigrid& multigrid() { return *multigrid_; }
  const LatticeElasticity& elasticity() const { return elasticity_; }
  std::int64_t bytes() const;

private:
  using Round = CoupledRound;

  Round correct(Displacement& u, Answer& answer);
  void begin_round(const Displacement& u);
  double find_residual(const Displacement& u);
  double work_of_forces(const float* direction);
  void take_step(double step, Displacement& u);
  template<class Visit>
  void for_each_row(const Visit& visit);

  const CoupledTask& task_;
  LatticeElasticity elasticity_;
  std::array<std::vector<double>, 3> loads_; ///< [N]; empty: none along that component
  std::unique_ptr<MatterMultigrid> multigrid_;
  AlignedArray<float> direction_;
  Displacement forces_;
  double scale_ = 1;       ///< residuals are counted in this times the level's unit [m]
  double energy_ = 0;      ///< u . K u in units of the level's unit [m^2]
  double round_began_ = 0; ///< r . z of the last round [m^2]
  double first_began_ = 0; ///< of the first
  CoupledError error_;
};

} // namespace maille::deform
