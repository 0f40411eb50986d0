#include "elastic/box/box_multigrid.hpp"

namespace maille::deform {

void BoxMultigrid::set_penalties(List<PenaltyLink> links) {
  for (std::size_t i = 0; i < n_levels(); ++i) {
    level(i).set_penalties(links);
    if (i + 1 < n_levels())
      links = level(i).coarse_links(links);
  }
  factor_coarsest();
}

const double* BoxMultigrid::forces_of_plane(const Displacement& u, int z) const {
  double* const forces = scratch_of_thread<double, BoxMultigrid>(3 * in_plane());
  apply_box(finest().A(), z, u.values().data(), forces, finest().scratch());
  return forces;
}

} // namespace maille::deform
