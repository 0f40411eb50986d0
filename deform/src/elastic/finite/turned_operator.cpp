#include "elastic/finite/turned_operator.hpp"

#include "elastic/masked/masked_solver.hpp"
#include "elastic/multigrid/chebyshev.hpp"
#include "maille/scene/block_frames.hpp"

#include <utility>

namespace maille::deform {

namespace {

/// Multigrid of a lattice whose cells have individual stiffnesses.
class RefreshedOperator : public ElasticOperator {
public:
  RefreshedOperator(const CoupledTask& task, const FiniteElasticity& elasticity)
      : linear_(task.scene, task.team,
                [&](std::int64_t cell) { return elasticity.stiffness_in_frame(cell); }),
        multigrid_(std::make_unique<MaskedLevel>(task.scene, linear_, task.prescribed, task.team,
                                                 Slabs(task.scene.specimen, nullptr)),
                   relaxation_steps(largest_contrast(task.scene)), task.team),
        system_(task.scene.specimen.grid, linear_, multigrid_, task.team) {}
  void apply(const Displacement& u, Displacement& forces) override { system_.apply(u, forces); }
  void precondition(const Displacement& residual, Displacement& correction) override {
    system_.precondition(residual, correction);
  }

private:
  LatticeElasticity linear_;
  MaskedMultigrid multigrid_;
  MaskedSystem system_;
};

} // namespace

TurnedPreconditioner::TurnedPreconditioner(const CoupledTask& task, std::shared_ptr<ElasticOperator> at_rest)
    : task_(task), at_rest_(std::move(at_rest)), turned_(task.scene.specimen.grid) {
  const auto n = static_cast<std::size_t>(task.scene.specimen.grid.n_nodes());
  may_turn_.assign(n, true);
  rotation_.assign(n, Eigen::Quaterniond::Identity());
  for (const Prescribed& p : task.prescribed)
    may_turn_[p.node] = false;
}

bool TurnedPreconditioner::refresh(const FiniteElasticity& elasticity) {
  if (task_.scene.dimension() < 3)
    return false;
  at_rest_.reset(); // so that two hierarchies never coexist
  at_rest_ = std::make_shared<RefreshedOperator>(task_, elasticity);
  return true;
}

void TurnedPreconditioner::turn_with(const FiniteElasticity& elasticity) {
  const Specimen& body = task_.scene.specimen;
  const Grid& grid = body.grid;
  const int planes = grid.nodes()[grid.dimension() - 1];
  const std::int64_t in_plane = grid.n_nodes() / planes;
  task_.team.run(planes, [&](int plane, int) {
    for (std::int64_t node = plane * in_plane; node < (plane + 1) * in_plane; ++node) {
      if (!may_turn_[node])
        continue;
      MeanRotation mean;
      body.for_each_cell_at(grid.node_at(node),
                            [&](std::int64_t cell) { mean.add(elasticity.frames()[cell]); });
      rotation_[node] = mean.value();
    }
  });
}

void TurnedPreconditioner::turn(Displacement& field, bool forth) const {
  const Grid& grid = task_.scene.specimen.grid;
  if (grid.dimension() == 1)
    return;
  const bool has_z = grid.dimension() == 3;
  const int planes = grid.nodes()[grid.dimension() - 1];
  const auto in_plane = static_cast<std::size_t>(grid.n_nodes() / planes);
  double *const x = field.component(0).data(), *const y = field.component(1).data(),
                *const z = has_z ? field.component(2).data() : nullptr;
  task_.team.run(planes, [&](int plane, int) {
    const auto first = static_cast<std::size_t>(plane) * in_plane;
    for (std::size_t i = first; i < first + in_plane; ++i) {
      const Eigen::Quaterniond& q = rotation_[i];
      const double w = forth ? q.w() : -q.w(), a = x[i], b = y[i], c = has_z ? z[i] : 0;
      const double p = q.y() * c - q.z() * b, r = q.z() * a - q.x() * c, s = q.x() * b - q.y() * a;
      x[i] = a + 2 * (w * p + q.y() * s - q.z() * r);
      y[i] = b + 2 * (w * r + q.z() * p - q.x() * s);
      if (has_z)
        z[i] = c + 2 * (w * s + q.x() * r - q.y() * p);
    }
  });
}

void TurnedPreconditioner::apply(const Displacement& residual, Displacement& correction) {
  turned_ = residual;
  turn(turned_, false);
  at_rest_->precondition(turned_, correction);
  turn(correction, true);
}

} // namespace maille::deform
