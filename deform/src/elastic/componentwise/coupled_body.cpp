#include "elastic/componentwise/componentwise_solver.hpp"
#include "elastic/krylov/flexible_gradients.hpp"
#include "elastic/model/lattice_elasticity.hpp"
#include "maille/scene/nodal_forces.hpp"

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

namespace maille::deform {

namespace {

class BodySolver : public CoupledSystem, public FlexibleOperator {
public:
  /// @param u taken to the answer
  BodySolver(const CoupledTask& task, Displacement& u);
  void apply(const Displacement& u, Displacement& forces) override {
    elasticity_.apply(u, forces, task_.team);
  }
  void precondition(const Displacement& residual, Displacement& correction) override;
  Displacement diagonal() const override { return diagonal_; }
  FlexibleGradients& gradients() { return *gradients_; }
  /// But for the gradients'.
  std::int64_t held_bytes() const;

private:
  void prescribe(Displacement& u);
  std::size_t d() const { return static_cast<std::size_t>(scene_.dimension()); }

  const CoupledTask& task_;
  const Scene& scene_;
  LatticeElasticity elasticity_;
  std::vector<std::unique_ptr<ComponentwiseSolver>> componentwise_;
  Displacement diagonal_;
  std::optional<FlexibleGradients> gradients_;
};

BodySolver::BodySolver(const CoupledTask& task, Displacement& u)
    : task_(task), scene_(task.scene), elasticity_(scene_) {
  prescribe(u);
}

/// Prescribed values, and where no start is given one from the componentwise model, which knows no more than
/// each component by itself.
void BodySolver::prescribe(Displacement& u) {
  const Grid& grid = scene_.specimen.grid;
  const auto n = static_cast<std::size_t>(grid.n_nodes());
  std::vector<std::vector<bool>> is_fixed(d(), std::vector<bool>(n, false));
  for (std::size_t node = 0; node < n; ++node)
    if (!scene_.specimen.is_node(grid.node_at(static_cast<std::int64_t>(node))))
      for (std::size_t b = 0; b < d(); ++b)
        is_fixed[b][node] = true;
  const CellModuli moduli(scene_);
  diagonal_ = elasticity_.diagonal();
  std::vector<std::vector<double>> forces;
  for (std::size_t b = 0; b < d(); ++b) {
    const int component = static_cast<int>(b);
    std::vector<FixedNode> fixed;
    for (const Prescribed& p : task_.prescribed)
      if (p.component == component) {
        fixed.push_back({p.node, p.value});
        is_fixed[b][static_cast<std::size_t>(p.node)] = true;
      }
    std::ranges::sort(fixed, {}, &FixedNode::node);
    forces.push_back(nodal_forces(scene_, component));
    const bool is_at_rest = std::ranges::all_of(fixed, [](const FixedNode& f) { return f.value == 0; });
    componentwise_.push_back(
        std::make_unique<ComponentwiseSolver>(scene_, moduli, component, fixed, task_.team));
    if (task_.start != nullptr)
      for (const FixedNode& f : fixed)
        u(component, f.node) = f.value;
    else if (!is_at_rest)
      componentwise_[b]->solve(u.component[b], {}, std::numeric_limits<double>::infinity(), false,
                               task_.must_stop);
    for (std::size_t node = 0; node < n; ++node)
      if (task_.start == nullptr && componentwise_[b]->has_loose_nodes() &&
          componentwise_[b]->is_loose(static_cast<std::int64_t>(node)))
        u.component[b][node] = 0;
  }
  gradients_.emplace(task_, std::move(forces), std::move(is_fixed));
}

void BodySolver::precondition(const Displacement& residual, Displacement& correction) {
  for (std::size_t b = 0; b < d(); ++b) {
    ComponentwiseSolver& solver = *componentwise_[b];
    solver.precondition(residual.component[b], correction.component[b]);
    for (std::size_t i = 0; i < correction.component[b].size(); ++i)
      if (gradients_->is_fixed(b, i))
        correction.component[b][i] = 0;
      else if (solver.has_loose_nodes() && solver.is_loose(static_cast<std::int64_t>(i)))
        correction.component[b][i] = residual.component[b][i] / diagonal_.component[b][i];
  }
}

std::int64_t BodySolver::held_bytes() const {
  std::int64_t sum = 2 * bytes_of(diagonal_) + elasticity_.bytes();
  for (const auto& solver : componentwise_)
    sum += solver->bytes();
  return sum;
}

} // namespace

bool solve_coupled_body(const CoupledTask& task, Answer& answer) {
  answer.algorithm = "lattice elasticity, conjugate gradients around componentwise multigrid";
  answer.displacement = task.start != nullptr ? *task.start : Displacement(task.scene.specimen.grid);
  BodySolver solver(task, answer.displacement);
  answer.seconds.setup = task.clock.seconds();
  answer.bytes = solver.held_bytes();
  return solver.gradients().finish(solver, solver, answer);
}

} // namespace maille::deform
