#include "maille/scene/nodal_forces.hpp"

#include <algorithm>

namespace maille {

std::vector<double> nodal_forces(const Scene& scene, int component) {
  const auto b = static_cast<std::size_t>(component);
  const Grid& grid = scene.specimen.grid;
  const bool is_pulled =
      std::ranges::any_of(scene.tractions, [&](const FaceLoad& load) { return load.traction[b] != 0; });
  if (scene.gravity[b] == 0 && !is_pulled)
    return {};
  std::vector<double> forces(static_cast<std::size_t>(grid.n_nodes()), 0);
  const int corners = grid.corners_per_cell();
  double volume = 1;
  for (int axis = 0; axis < grid.dimension(); ++axis)
    volume *= grid.spacing()[static_cast<std::size_t>(axis)];
  for (std::int64_t cell = 0; scene.gravity[b] != 0 && cell < grid.n_cells(); ++cell) {
    if (!scene.specimen.is_matter(cell))
      continue;
    const double weight = scene.materials[scene.specimen.material(cell)].density * scene.gravity[b] * volume;
    for (int corner = 0; corner < corners; ++corner)
      forces[static_cast<std::size_t>(grid.corner(grid.cell_at(cell), corner))] += weight / corners;
  }
  for (const FaceLoad& load : scene.tractions) {
    const double area = volume / grid.spacing()[static_cast<std::size_t>(load.axis)];
    for (int corner = 0; corner < corners; ++corner)
      if ((corner >> load.axis & 1) == (load.upper ? 1 : 0))
        forces[static_cast<std::size_t>(grid.corner(grid.cell_at(load.cell), corner))] +=
            load.traction[b] * area * 2 / corners;
  }
  return forces;
}

} // namespace maille
