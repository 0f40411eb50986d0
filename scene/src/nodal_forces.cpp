#include "maille/base/vectors.hpp"
#include "maille/scene/scene.hpp"

#include <algorithm>
#include <cstdint>

namespace maille {

namespace {

void add_weight(const Scene& scene, std::size_t b, List<double>& forces) {
  const Grid& grid = scene.specimen.grid;
  const int corners = grid.corners_per_cell();
  const double volume = cell_volume(grid);
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    if (!scene.specimen.is_matter(cell))
      continue;
    const double weight = scene.materials[scene.specimen.material(cell)].density *
                          scene.specimen.tissue_of(cell) * scene.gravity[b] * volume;
    for (int corner = 0; corner < corners; ++corner)
      forces[grid.corner(grid.cell_at(cell), corner)] += weight / corners;
  }
}

void add_tractions(const Scene& scene, std::size_t b, List<double>& forces) {
  const Grid& grid = scene.specimen.grid;
  const int corners = grid.corners_per_cell();
  for (const FaceLoad& load : scene.tractions) {
    const double area = cell_volume(grid) / grid.spacing()[load.axis];
    for (int corner = 0; corner < corners; ++corner)
      if ((corner >> load.axis & 1) == (load.upper ? 1 : 0))
        forces[grid.corner(grid.cell_at(load.cell), corner)] += load.traction[b] * area * 2 / corners;
  }
}

/// Index of component b of the stress on a face normal to `axis`, in a stress of the scene's dimension.
Eigen::Index place(int dimension, int b, int axis) {
  if (b == axis)
    return b;
  return dimension == 2 ? 2 : 6 - b - axis; // 12 | 23 13 12
}

/// The mean gradient of a corner's shape function is 2 / corners / spacing along each axis, positive for
/// upper corners.
void add_contraction(const Scene& scene, int b, List<double>& forces) {
  const Grid& grid = scene.specimen.grid;
  const int d = grid.dimension(), corners = grid.corners_per_cell();
  const double share = cell_volume(grid) * 2 / corners;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    if (!scene.specimen.is_matter(cell) || scene.active_stress[cell] == 0)
      continue;
    const Eigen::VectorXd stress = scene.specimen.tissue_of(cell) * scene.cell_active_stress(cell);
    for (int corner = 0; corner < corners; ++corner) {
      double force = 0;
      for (int axis = 0; axis < d; ++axis)
        force += (corner >> axis & 1 ? -share : share) / grid.spacing()[axis] * stress(place(d, b, axis));
      forces[grid.corner(grid.cell_at(cell), corner)] += force;
    }
  }
}

} // namespace

List<double> nodal_forces(const Scene& scene, int component) {
  const auto b = static_cast<std::size_t>(component);
  const bool is_pulled =
      std::ranges::any_of(scene.tractions, [&](const FaceLoad& load) { return load.traction[b] != 0; });
  if (scene.gravity[b] == 0 && !is_pulled && !scene.contracts())
    return {};
  List<double> forces(static_cast<std::size_t>(scene.specimen.grid.n_nodes()), 0);
  if (scene.gravity[b] != 0)
    add_weight(scene, b, forces);
  add_tractions(scene, b, forces);
  if (scene.contracts())
    add_contraction(scene, component, forces);
  return forces;
}

} // namespace maille
