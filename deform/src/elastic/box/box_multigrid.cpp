#include "elastic/box/box_multigrid.hpp"

namespace maille::deform {

void BoxMultigrid::set_penalties(std::vector<PenaltyLink> links) {
  for (std::size_t i = 0; i < n_levels(); ++i) {
    level(i).set_penalties(links);
    if (i + 1 < n_levels())
      links = level(i).coarse_links(links);
  }
  factor_coarsest();
}

const double* BoxMultigrid::forces_of_plane(const Displacement& u, int z) const {
  thread_local AlignedArray<double> forces;
  if (forces.size() < 3 * in_plane())
    forces = AlignedArray<double>(3 * in_plane());
  apply_box(finest().A(), z, u.values().data(), forces.data(), finest().scratch());
  return forces.data();
}

} // namespace maille::deform
