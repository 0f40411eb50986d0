#pragma once
/// Small bodies for tests of files and pictures: values without symmetry, so that a swap shows.

#include "maille/scene/answer.hpp"

#include <cmath>
#include <string>

namespace maille::test {

/// @param cells  per axis; axes beyond the dimension are ignored
inline Scene block(int dimension, Index3 cells) {
  Scene scene;
  scene.name = "block";
  scene.specimen.shape = "box";
  scene.specimen.grid = Grid(dimension, cells, {1e-3, 2e-3, 3e-3});
  scene.specimen.origin = {0.5e-3, -0.25e-3, dimension == 3 ? 0.125e-3 : 0.0};
  scene.specimen.fibre = {0.6, 0.8, 0};
  scene.materials = {{"soft", ElasticConstants::isotropic(1e4, 0.3), {}, 1000, {}, {}},
                     {"hard", ElasticConstants::isotropic(5e4, 0.2), {}, 1000, {}, {}}};
  return scene;
}

/// A block with matter of two kinds and holes: cells whose number is 1 modulo 3 are empty, every fifth is
/// hard.
inline Scene block_with_holes(int dimension, Index3 cells) {
  Scene scene = block(dimension, cells);
  for (std::int64_t cell = 0; cell < scene.specimen.grid.n_cells(); ++cell)
    scene.specimen.material_id.push_back(cell % 3 == 1 ? no_material : cell % 5 == 0 ? 1 : 0);
  return scene;
}

/// A smooth displacement with all 53 bits in use; zero where there is no matter. @param size  [m]
inline Displacement wave(const Scene& scene, double size, double phase = 0) {
  const Grid& grid = scene.specimen.grid;
  Displacement displacement(grid);
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
    for (int axis = 0; axis < grid.dimension(); ++axis)
      if (scene.specimen.is_node(grid.node_at(node)))
        displacement(axis, node) = size * std::sin(0.37 * static_cast<double>(node) + axis + phase);
  return displacement;
}

} // namespace maille::test
