#include "elastic/corotated/corotated_relaxation.hpp"

#include "elastic/box/box_solver.hpp"
#include "elastic/componentwise/componentwise_preconditioner.hpp"
#include "elastic/masked/masked_solver.hpp"
#include "maille/scene/block_frames.hpp"

#include <algorithm>

namespace maille::deform {

namespace {

class BoxAtRest : public RestPreconditioner {
public:
  explicit BoxAtRest(const CoupledTask& task) : solver_(task), system_(solver_.multigrid(), solver_.unit()) {}
  void apply(const Displacement& residual, Displacement& correction) override {
    system_.precondition(residual, correction);
  }
  void set_penalties(const List<PenaltyLink>& links) override { system_.set_penalties(links); }

private:
  BoxSolver solver_;
  BoxSystem system_;
};

class MaskedAtRest : public RestPreconditioner {
public:
  explicit MaskedAtRest(const CoupledTask& task)
      : solver_(task),
        system_(task.scene.specimen.grid, solver_.elasticity(), solver_.multigrid(), task.team) {}
  void apply(const Displacement& residual, Displacement& correction) override {
    std::ranges::fill(correction.values(), 0.0); // the system knows nothing of nodes without tissue
    system_.precondition(residual, correction);
  }
  void set_penalties(const List<PenaltyLink>& links) override { system_.set_penalties(links); }

private:
  MaskedSolver solver_;
  MaskedSystem system_;
};

/// 2D: the componentwise model's, as in `coupled`.
class PlaneAtRest : public RestPreconditioner {
public:
  explicit PlaneAtRest(const CoupledTask& task)
      : moduli_(task.scene), preconditioner_(task.scene, moduli_, {0, 1}, task.prescribed, task.team) {}
  void apply(const Displacement& residual, Displacement& correction) override {
    preconditioner_.precondition(residual, correction);
  }
  void set_penalties(const List<PenaltyLink>& links) override { preconditioner_.set_penalties(links); }

private:
  CellModuli moduli_;
  ComponentwisePreconditioner preconditioner_;
};

} // namespace

std::unique_ptr<RestPreconditioner> make_rest_preconditioner(const CoupledTask& task) {
  if (is_uniform_box(task.scene))
    return std::make_unique<BoxAtRest>(task);
  if (task.scene.dimension() == 3)
    return std::make_unique<MaskedAtRest>(task);
  return std::make_unique<PlaneAtRest>(task);
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
        v[static_cast<Eigen::Index>(b)] = field(b, i);
      v = forth ? rotation_[i] * v : rotation_[i].conjugate() * v;
      for (std::size_t b = 0; b < d; ++b)
        field(b, i) = v[static_cast<Eigen::Index>(b)];
    }
  });
}

void CorotatedPreconditioner::apply(Displacement& residual, Displacement& correction) {
  turn(residual, false);
  at_rest_->apply(residual, correction);
  turn(correction, true);
}

} // namespace maille::deform
