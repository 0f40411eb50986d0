#pragma once
/// Bodies with holes and several materials, built without a file.

#include "support/bodies/scenes.hpp"

#include <cmath>
#include <cstdint>

namespace maille::test {

enum class Fibres { none, slanted, turning };

/// Holds the lower nodes of the body along the last axis and moves the upper ones.
inline void hold_and_move_ends(Scene& scene, const Vec3& by = {0.1e-3, 0, 0.05e-3}) {
  hold_face(scene, 2, false);
  move_face(scene, 2, true, by);
}

/// A box of three irregularly mixed materials; a seventh of the cells is missing, except in the first and
/// last layer.
inline Scene carved_body(Index3 cells, Fibres fibres, Vec3 spacing = {1e-3, 1.3e-3, 0.8e-3}) {
  Scene scene = box_scene(3, cells, spacing);
  scene.materials.assign(3, scene.materials[0]);
  scene.materials[1].elasticity = ElasticConstants::isotropic(80e3, 0.4);
  if (fibres != Fibres::none)
    scene.materials[2].elasticity = ElasticConstants::transversely_isotropic(100e3, 10e3, 6e3, 0.3, 0.4);
  scene.specimen.fibre = {0.48, 0.6, 0.64};
  const Grid& grid = scene.specimen.grid;
  std::uint32_t random = 1;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    random = random * 1664525u + 1013904223u;
    const int z = grid.cell_at(cell)[2];
    const bool may_be_missing = z > 0 && z + 1 < cells[2];
    scene.specimen.material_id.push_back(
        may_be_missing && (random >> 8) % 7 == 0 ? no_material : std::uint8_t((random >> 16) % 3));
    const auto angle = float(cell);
    if (fibres == Fibres::turning)
      scene.specimen.fibres.push_back({std::sin(angle), 0.0f, std::cos(angle)});
  }
  hold_and_move_ends(scene);
  return scene;
}

/// Two cubes of n cells per axis, one above the other, that share a corner, an edge or a face: they overlap
/// along `contact` of the axes, and touch along the others.
inline Scene two_blocks(int n, int contact) {
  Scene scene = box_scene(3, {contact < 3 ? 2 * n : n, contact < 2 ? 2 * n : n, 2 * n});
  const Grid& grid = scene.specimen.grid;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    const Index3 at = grid.cell_at(cell);
    const bool is_lower = at[2] < n, is_before = at[0] < n, is_in_front = at[1] < n;
    const bool is_matter =
        (contact == 3 || is_before == is_lower) && (contact > 1 || is_in_front == is_lower);
    scene.specimen.material_id.push_back(is_matter ? std::uint8_t{0} : no_material);
  }
  hold_and_move_ends(scene);
  return scene;
}

} // namespace maille::test
