#pragma once
/// The componentwise model as a preconditioner, of full elasticity on any body among others, and as an
/// operator of its own.

#include "elastic/componentwise/componentwise_solver.hpp"
#include "elastic/krylov/coupled_system.hpp"
#include "elastic/krylov/flexible_gradients.hpp"
#include "elastic/links/penalty_rows.hpp"
#include "elastic/model/lattice_elasticity.hpp"

#include <memory>
#include <vector>

namespace maille::deform {

/// One multigrid cycle of the componentwise model per component. Penalties of links just raise their weights.
///
/// Set up when it is first used. Same bits for any number of threads.
class ComponentwisePreconditioner {
public:
  /// All but `components` must outlive this.
  ComponentwisePreconditioner(const Scene& scene, const CellModuli& moduli,
                              const std::vector<int>& components, const std::vector<Prescribed>& prescribed,
                              ThreadTeam& team);

  /// These links have penalties from now on, and no others. Components for which nothing changes stay.
  void set_penalties(const List<PenaltyLink>& links);
  /// correction = B residual for every component, B symmetric and positive definite where it may move, 0
  /// elsewhere, but for rounding to float32; residual [N] and correction [m] dense, of those components
  /// alone.
  void precondition(const Displacement& residual, Displacement& correction);
  /// What solves for one component, with the prescribed values. @pre one of the components
  ComponentwiseSolver& solver(int component);

private:
  struct Part {
    int component = 0;
    List<PenaltyLink> penalties;
    double unit = 0;     ///< of the weights [N/m]; 0: not known yet, as the next three
    LinkWeights weights; ///< one per link, without penalties
    List<FixedNode> fixed;
    std::vector<bool> is_loose;
    std::unique_ptr<ComponentwiseSolver> solver; ///< null: not set up
  };
  ComponentwiseSolver& solver_of(Part& part) const;
  void set_up(Part& part) const;

  const Scene& scene_;
  const CellModuli& moduli_;
  const std::vector<Prescribed>& prescribed_;
  ThreadTeam& team_;
  std::vector<Part> parts_;
};

/// Where a component is prescribed, ascending by node. @param prescribed of any component
List<FixedNode> fixed_nodes(const std::vector<Prescribed>& prescribed, int component);

/// The operator of one component of `relaxed`.
class ComponentwiseSystem : public CoupledSystem {
public:
  /// @param solver must outlive this
  ComponentwiseSystem(const ComponentwiseSolver& solver, int component)
      : solver_(solver), component_(component) {}
  /// @param u of that component alone, as forces are, or of all
  void apply(const Displacement& u, Displacement& forces) override {
    solver_.apply(u.component(u.n_components() == 1 ? 0 : component_), forces.component(0));
  }

private:
  const ComponentwiseSolver& solver_;
  int component_;
};

/// 0 to dimension - 1.
std::vector<int> all_components(const Scene& scene);

/// In float64, cell by cell.
class BodySystem : public CoupledSystem, public FlexibleOperator {
public:
  /// @param task must outlive this
  explicit BodySystem(const CoupledTask& task);
  void apply(const Displacement& u, Displacement& forces) override {
    elasticity_.apply(u, forces, task_.team);
  }
  void precondition(const Displacement& residual, Displacement& correction) override {
    preconditioner_.precondition(residual, correction);
  }
  Displacement diagonal() const override { return elasticity_.diagonal(); }

  /// Prescribed values, and where no start is given one from the componentwise model, which knows no more
  /// than each component by itself.
  void prescribe(Displacement& u);

protected:
  const CoupledTask& task() const { return task_; }
  const LatticeElasticity& elasticity() const { return elasticity_; }

private:
  const CoupledTask& task_;
  LatticeElasticity elasticity_;
  CellModuli moduli_;
  ComponentwisePreconditioner preconditioner_;
};

} // namespace maille::deform
