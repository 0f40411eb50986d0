#include "elastic/corotated/corotated_preconditioner.hpp"

#include "elastic/box/box_solver.hpp"
#include "elastic/componentwise/componentwise_solver.hpp"
#include "elastic/masked/masked_solver.hpp"
#include "maille/scene/nearest_rotation.hpp"

#include <algorithm>

namespace maille::deform {

namespace {

/// 3D: the multigrid that Solver has for its own conjugate gradients.
template<class Solver>
class MultigridPreconditioner : public RestPreconditioner {
public:
  explicit MultigridPreconditioner(const CoupledTask& task) : solver_(task) {}
  void apply(const Displacement& residual, Displacement& correction) override {
    solver_.precondition(residual, correction);
  }
  std::int64_t bytes() const override { return solver_.bytes(); }

private:
  Solver solver_;
};

/// 2D: one cycle per component of the componentwise model, as in `coupled`; the diagonal where that has no
/// hold.
class ComponentwisePreconditioner : public RestPreconditioner {
public:
  explicit ComponentwisePreconditioner(const CoupledTask& task);
  void apply(const Displacement& residual, Displacement& correction) override;
  std::int64_t bytes() const override;

private:
  std::vector<std::unique_ptr<ComponentwiseSolver>> solver_;
  std::vector<std::vector<bool>> is_free_; ///< [component][node]
  Displacement diagonal_;
};

ComponentwisePreconditioner::ComponentwisePreconditioner(const CoupledTask& task)
    : diagonal_(LatticeElasticity(task.scene).diagonal()) {
  const Grid& grid = task.scene.specimen.grid;
  const CellModuli moduli(task.scene);
  for (int component = 0; component < grid.dimension(); ++component) {
    std::vector<bool> is_free(static_cast<std::size_t>(grid.n_nodes()));
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
      is_free[static_cast<std::size_t>(node)] = task.scene.specimen.is_node(grid.node_at(node));
    std::vector<FixedNode> fixed;
    for (const Prescribed& p : task.prescribed)
      if (p.component == component) {
        fixed.push_back({p.node, 0});
        is_free[static_cast<std::size_t>(p.node)] = false;
      }
    std::ranges::sort(fixed, {}, &FixedNode::node);
    solver_.push_back(
        std::make_unique<ComponentwiseSolver>(task.scene, moduli, component, std::move(fixed), task.team));
    is_free_.push_back(std::move(is_free));
  }
}

void ComponentwisePreconditioner::apply(const Displacement& residual, Displacement& correction) {
  for (std::size_t b = 0; b < solver_.size(); ++b) {
    ComponentwiseSolver& solver = *solver_[b];
    std::vector<double>& values = correction.component[b];
    solver.precondition(residual.component[b], values);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (!is_free_[b][i])
        values[i] = 0;
      else if (solver.has_loose_nodes() && solver.is_loose(static_cast<std::int64_t>(i)))
        values[i] = residual.component[b][i] / diagonal_.component[b][i];
    }
  }
}

std::int64_t ComponentwisePreconditioner::bytes() const {
  std::int64_t sum = bytes_of(diagonal_);
  for (std::size_t b = 0; b < solver_.size(); ++b)
    sum += solver_[b]->bytes() + static_cast<std::int64_t>(is_free_[b].size() / 8);
  return sum;
}

} // namespace

std::unique_ptr<RestPreconditioner> make_rest_preconditioner(const CoupledTask& task) {
  if (is_uniform_box(task.scene))
    return std::make_unique<MultigridPreconditioner<BoxSolver>>(task);
  if (task.scene.dimension() == 3)
    return std::make_unique<MultigridPreconditioner<MaskedSolver>>(task);
  return std::make_unique<ComponentwisePreconditioner>(task);
}

CorotatedPreconditioner::CorotatedPreconditioner(const CoupledTask& task)
    : task_(task), at_rest_(make_rest_preconditioner(task)) {
  const auto n = static_cast<std::size_t>(task.scene.specimen.grid.n_nodes());
  may_turn_.assign(n, true);
  rotation_.assign(n, Eigen::Quaterniond::Identity());
  for (const Prescribed& p : task.prescribed)
    may_turn_[static_cast<std::size_t>(p.node)] = false;
}

void CorotatedPreconditioner::turn_with(const CorotatedElasticity& elasticity) {
  const Specimen& body = task_.scene.specimen;
  const Grid& grid = body.grid;
  const int planes = grid.nodes()[static_cast<std::size_t>(grid.dimension() - 1)];
  const std::int64_t in_plane = grid.n_nodes() / planes;
  task_.team.run(planes, [&](int plane, int) {
    for (std::int64_t node = plane * in_plane; node < (plane + 1) * in_plane; ++node) {
      if (!may_turn_[static_cast<std::size_t>(node)])
        continue;
      MeanRotation mean;
      body.for_each_cell_at(grid.node_at(node), [&](std::int64_t cell) {
        mean.add(elasticity.frames()[static_cast<std::size_t>(cell)]);
      });
      rotation_[static_cast<std::size_t>(node)] = mean.value();
    }
  });
}

void CorotatedPreconditioner::turn(Displacement& field, bool forth) const {
  const Grid& grid = task_.scene.specimen.grid;
  const auto d = static_cast<std::size_t>(grid.dimension());
  const int planes = grid.nodes()[d - 1];
  const auto in_plane = static_cast<std::size_t>(grid.n_nodes() / planes);
  task_.team.run(planes, [&](int plane, int) {
    const auto first = static_cast<std::size_t>(plane) * in_plane;
    for (std::size_t i = first; i < first + in_plane; ++i) {
      Eigen::Vector3d v = Eigen::Vector3d::Zero();
      for (std::size_t b = 0; b < d; ++b)
        v[static_cast<Eigen::Index>(b)] = field.component[b][i];
      v = forth ? rotation_[i] * v : rotation_[i].conjugate() * v;
      for (std::size_t b = 0; b < d; ++b)
        field.component[b][i] = v[static_cast<Eigen::Index>(b)];
    }
  });
}

void CorotatedPreconditioner::apply(Displacement& residual, Displacement& correction) {
  turn(residual, false);
  at_rest_->apply(residual, correction);
  turn(correction, true);
}

std::int64_t CorotatedPreconditioner::bytes() const {
  return at_rest_->bytes() +
         static_cast<std::int64_t>(rotation_.size() * sizeof(rotation_[0]) + may_turn_.size() / 8);
}

} // namespace maille::deform
