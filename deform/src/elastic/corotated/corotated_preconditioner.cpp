#include "elastic/corotated/corotated_relaxation.hpp"

#include "maille/scene/block_frames.hpp"

#include <algorithm>
#include <utility>

namespace maille::deform {

CorotatedPreconditioner::CorotatedPreconditioner(const CoupledTask& task,
                                                 std::shared_ptr<ElasticOperator> at_rest)
    : task_(task), at_rest_(std::move(at_rest)) {
  const auto n = static_cast<std::size_t>(task.scene.specimen.grid.n_nodes());
  may_turn_.assign(n, true);
  rotation_.assign(n, Eigen::Quaterniond::Identity());
  for (const Prescribed& p : task.prescribed)
    may_turn_[p.node] = false;
}

void CorotatedPreconditioner::turn_with(const CorotatedElasticity& elasticity) {
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
  at_rest_->precondition(residual, correction);
  turn(correction, true);
}

} // namespace maille::deform
