#pragma once
/// Operators of a body in a finite-strain state: its tangent, and the lattice's multigrid in turned frames.
///
/// The preconditioner turns forces back node by node, by the mean of the frames around, solves with the body
/// at rest, and turns the correction forth. In coordinates that turn with the body the tangent is nearly a
/// lattice of small strain, whose stiffness refresh() takes from the present state: the tangent for strains
/// in each cell's frame. The stiffness of tension against turns is left out; conjugate gradients find it.
///
/// Exact: the tangent. Heuristic: the preconditioner. Nodes of which only some components are free stay
/// unturned: their directions are the world's.

#include "elastic/finite/finite_elasticity.hpp"
#include "elastic/finite/turned_limits.hpp"
#include "elastic/krylov/coupled_task.hpp"
#include "elastic/krylov/elastic_operator.hpp"

#include "maille/base/arena.hpp"

#include <memory>

namespace maille::deform {

class TurnedPreconditioner {
public:
  /// @param task must outlive this @param at_rest operator of the body at rest
  TurnedPreconditioner(const CoupledTask& task, std::shared_ptr<ElasticOperator> at_rest);

  void turn_with(const FiniteElasticity& elasticity);
  /// Rebuilds the preconditioner from the state of the last linearise(). @return false in 1D and 2D, which
  /// have no such preconditioner
  bool refresh(const FiniteElasticity& elasticity);
  /// See ElasticOperator.
  void apply(const Displacement& residual, Displacement& correction);

private:
  void turn(Displacement& field, bool forth) const;

  const CoupledTask& task_;
  std::shared_ptr<ElasticOperator> at_rest_;
  List<bool> may_turn_;               ///< by node
  List<Eigen::Quaterniond> rotation_; ///< by node
  Displacement turned_;
};

/// The tangent of the last FiniteElasticity::linearise(), active limits included, around the preconditioner.
class TangentOperator : public ElasticOperator {
public:
  /// All must outlive this. @param limits null: none
  TangentOperator(const FiniteElasticity& elasticity, const TurnedLimits* limits,
                  TurnedPreconditioner& preconditioner, ThreadTeam& team)
      : elasticity_(elasticity), limits_(limits), preconditioner_(preconditioner), team_(team) {}
  void apply(const Displacement& u, Displacement& forces) override {
    elasticity_.apply_tangent(u, forces, team_);
    if (limits_ != nullptr)
      limits_->add_tangent(u, forces);
  }
  void precondition(const Displacement& residual, Displacement& correction) override {
    preconditioner_.apply(residual, correction);
  }

private:
  const FiniteElasticity& elasticity_;
  const TurnedLimits* limits_;
  TurnedPreconditioner& preconditioner_;
  ThreadTeam& team_;
};

} // namespace maille::deform
