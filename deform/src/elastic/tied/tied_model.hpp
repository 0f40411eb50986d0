#pragma once
/// What conjugate gradients among displacements in which tied nodes move together go around.

#include "elastic/krylov/coupled_task.hpp"
#include "elastic/krylov/elastic_operator.hpp"
#include "elastic/tied/tied_nodes.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace maille::deform {

/// Preconditioned by single bodies, each held softly where it is tied, and their answers brought together:
/// what a Neumann-Neumann method does with its coarse space in the springs.
class TiedModel : public ElasticOperator {
public:
  /// @param task outlives it; @param diagonal of the operator [N/m]
  TiedModel(const CoupledTask& task, Displacement diagonal)
      : task_(task), fixed_(task.scene.specimen, task.prescribed), diagonal_(std::move(diagonal)),
        ties_(task.scene.tied, fixed_, diagonal_), shared_(task.scene.specimen.grid) {}

  void precondition(const Displacement& residual, Displacement& correction) final {
    shared_ = residual;
    ties_.share(shared_);
    std::ranges::fill(correction.values(), 0.0);
    precondition_bodies(shared_, correction);
    ties_.bring_together(correction);
  }
  const Displacement& diagonal() const { return diagonal_; }

  /// Sets the weight of the links of `penalised` beside the operator.
  virtual void set_penalty(double) {}

  const CoupledTask& task() const { return task_; }
  const TiedNodes& ties() const { return ties_; }
  const FixedMask& fixed() const { return fixed_; }

protected:
  /// Preconditions the bodies without ties. @param correction 0 at first
  virtual void precondition_bodies(const Displacement& residual, Displacement& correction) = 0;

private:
  const CoupledTask& task_;
  FixedMask fixed_;
  Displacement diagonal_;
  TiedNodes ties_;
  Displacement shared_;
};

} // namespace maille::deform
