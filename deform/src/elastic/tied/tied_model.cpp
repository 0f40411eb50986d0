#include "elastic/tied/tied_model.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace maille::deform {

std::vector<std::vector<bool>> fixed_components(const CoupledTask& task) {
  const Specimen& body = task.scene.specimen;
  std::vector<bool> is_void(static_cast<std::size_t>(body.grid.n_nodes()));
  for (std::size_t node = 0; node < is_void.size(); ++node)
    is_void[node] = !body.is_node(body.grid.node_at(static_cast<std::int64_t>(node)));
  std::vector<std::vector<bool>> is_fixed(3, is_void);
  for (const Prescribed& p : task.prescribed)
    is_fixed[static_cast<std::size_t>(p.component)][static_cast<std::size_t>(p.node)] = true;
  return is_fixed;
}

TiedModel::TiedModel(const CoupledTask& task, Displacement diagonal)
    : task_(task), is_fixed_(fixed_components(task)), diagonal_(std::move(diagonal)),
      ties_(task.scene.tied, is_fixed_, diagonal_), shared_(task.scene.specimen.grid) {}

void TiedModel::precondition(const Displacement& residual, Displacement& correction) {
  shared_ = residual;
  ties_.share(shared_);
  std::ranges::fill(correction.values(), 0.0);
  precondition_bodies(shared_, correction);
  ties_.bring_together(correction);
}

OpenTie widest_tie(const NodeTies& tied, const Displacement& u) {
  OpenTie widest;
  for (const NodeTie& tie : tied.ties) {
    const Vec3 one = u.at(tie.one), other = u.at(tie.other);
    double along = 0, squared = 0;
    for (std::size_t b = 0; b < 3; ++b) {
      along += tie.normal[b] * (one[b] - other[b]);
      squared += (one[b] - other[b]) * (one[b] - other[b]);
    }
    const double gap = tie.normal == Vec3{} ? std::sqrt(squared) : std::abs(along);
    if (gap > widest.gap)
      widest = {gap, &tie};
  }
  return widest;
}

} // namespace maille::deform
