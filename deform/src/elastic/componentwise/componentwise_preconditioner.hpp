#pragma once
/// The componentwise model as a preconditioner, also of full elasticity, and as an operator.

#include "elastic/componentwise/componentwise_solver.hpp"
#include "elastic/krylov/coupled_task.hpp"
#include "elastic/krylov/elastic_operator.hpp"
#include "elastic/model/lattice_elasticity.hpp"

#include <memory>
#include <optional>
#include <vector>

namespace maille::deform {

/// One multigrid cycle of the componentwise model per component. A penalty raises the weight of its link.
///
/// Set up at first use. Same bits for any number of threads.
class ComponentwisePreconditioner {
public:
  /// All but `components` and `springs` must outlive this. @param springs to the ground, ascending by node;
  /// null: the scene's
  ComponentwisePreconditioner(const Scene& scene, const CellModuli& moduli,
                              const std::vector<int>& components, const std::vector<Prescribed>& prescribed,
                              ThreadTeam& team, std::optional<List<NodalSpring>> springs = {});

  /// Replaces the penalties. Components whose penalties do not change keep their set-up.
  void set_penalties(const List<PenaltyLink>& links);
  /// correction = B residual for every component. B is symmetric and positive definite on free nodes and 0
  /// elsewhere, within float32 rounding. residual [N] and correction [m] are dense and have only these
  /// components.
  void precondition(const Displacement& residual, Displacement& correction);
  /// The solver of one component, with the prescribed values. @pre one of the components
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
  bool has_own_springs_;
  List<NodalSpring> springs_;
  std::vector<Part> parts_;
};

/// Where a component is prescribed, ascending by node. @param prescribed of any component
List<FixedNode> fixed_nodes(const std::vector<Prescribed>& prescribed, int component);

/// 0 to dimension - 1.
std::vector<int> all_components(const Scene& scene);

/// Shared part of operators around the componentwise multigrid.
class ComponentwisePreconditioned : public PenalizedOperator {
public:
  const CoupledTask& task() const { return task_; }
  const CellModuli& moduli() const { return moduli_; }
  void precondition(const Displacement& residual, Displacement& correction) override {
    preconditioner_.precondition(residual, correction);
  }
  void set_penalties(const List<PenaltyLink>& links) override { preconditioner_.set_penalties(links); }

protected:
  /// @param task must outlive this @param springs as ComponentwisePreconditioner has them
  ComponentwisePreconditioned(const CoupledTask& task, CellModuli moduli, const std::vector<int>& components,
                              std::optional<List<NodalSpring>> springs = {})
      : task_(task), moduli_(std::move(moduli)),
        preconditioner_(task.scene, moduli_, components, task.prescribed, task.team, std::move(springs)) {}
  ComponentwisePreconditioner& preconditioner() { return preconditioner_; }

private:
  const CoupledTask& task_;
  CellModuli moduli_;
  ComponentwisePreconditioner preconditioner_;
};

/// One component of `relaxed`; its fields have this component only.
class ComponentwiseSystem : public ComponentwisePreconditioned {
public:
  /// @param solver of the component; must outlive this, as the task
  ComponentwiseSystem(const CoupledTask& task, const CellModuli& moduli, const ComponentwiseSolver& solver,
                      int component)
      : ComponentwisePreconditioned(task, moduli, {component}), solver_(solver) {}
  void apply(const Displacement& u, Displacement& forces) override {
    solver_.apply(u.component(0), forces.component(0));
  }

private:
  const ComponentwiseSolver& solver_;
};

/// Full elasticity on any body in 1D, 2D and 3D, cell by cell in float64.
class BodySystem : public ComponentwisePreconditioned {
public:
  /// @param task must outlive this
  explicit BodySystem(const CoupledTask& task);
  void apply(const Displacement& u, Displacement& forces) override {
    elasticity_.apply(u, forces, task().team);
  }

  /// Sets the prescribed values. Without a start, the componentwise model extends each component by itself.
  void prescribe(Displacement& u);

protected:
  const LatticeElasticity& elasticity() const { return elasticity_; }

private:
  LatticeElasticity elasticity_;
};

} // namespace maille::deform
