#include "elastic/componentwise/componentwise_multigrid.hpp"

namespace maille::deform {

void ComponentwiseMultigrid::solve_from_coarsest(bool has_forces) {
  for (std::size_t i = 0; i < n_levels(); ++i) {
    ComponentwiseLevel& here = level(i);
    here.clear(here.u);
    here.place_fixed(here.u.data());
    if (i == 0)
      continue;
    ComponentwiseLevel& finer = level(i - 1);
    if (has_forces)
      team_for(finer).run(here.n_planes(),
                          [&](int z, int) { finer.restrict_to(here, z, finer.f.data(), here.f.data()); });
    else
      here.clear(here.f);
  }
  ComponentwiseLevel& last = level(n_levels() - 1);
  for (int z = 0; z < last.n_planes(); ++z)
    last.find_residual(z);
  coarsest().add_solution(last.r.data(), last.u.data());
  for (std::size_t i = n_levels() - 1; i-- > 0;)
    cycle(i, {.from_coarser = true});
}

} // namespace maille::deform
