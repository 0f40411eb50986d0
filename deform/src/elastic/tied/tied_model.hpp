#pragma once
/// What conjugate gradients among displacements in which tied nodes move together go around.

#include "elastic/krylov/coupled_task.hpp"
#include "elastic/krylov/flexible_gradients.hpp"
#include "elastic/tied/tied_nodes.hpp"

#include <vector>

namespace maille::deform {

/// [component][node]: prescribed, or none of the body's.
std::vector<std::vector<bool>> fixed_components(const CoupledTask& task);

/// Preconditioned by single bodies, each held softly where it is tied, and their answers brought together:
/// what a Neumann-Neumann method does with its coarse space in the springs.
class TiedModel : public FlexibleOperator {
public:
  /// @param task outlives it; @param diagonal of the operator [N/m]
  TiedModel(const CoupledTask& task, Displacement diagonal);

  void precondition(const Displacement& residual, Displacement& correction) final;
  Displacement diagonal() const final { return diagonal_; }

  /// The links of `penalised` count so many times beside the operator from now on.
  virtual void set_penalty(double) {}

  const CoupledTask& task() const { return task_; }
  const TiedNodes& ties() const { return ties_; }
  const std::vector<std::vector<bool>>& is_fixed() const { return is_fixed_; }

protected:
  /// Of bodies by themselves. @param correction 0 at first
  virtual void precondition_bodies(const Displacement& residual, Displacement& correction) = 0;

private:
  const CoupledTask& task_;
  std::vector<std::vector<bool>> is_fixed_;
  Displacement diagonal_;
  TiedNodes ties_;
  Displacement shared_;
};

/// The farthest that ties are open [m], and which.
struct OpenTie {
  double gap = 0;
  const NodeTie* tie = nullptr;
};
OpenTie widest_tie(const NodeTies& tied, const Displacement& u);

} // namespace maille::deform
