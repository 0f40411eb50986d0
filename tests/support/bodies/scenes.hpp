#pragma once
/// Scenes that tests build without a file.

#include "maille/scene/scene.hpp"

#include <algorithm>

namespace maille::test {

/// A box of one isotropic material (E = 10 kPa, nu = 0.3), without conditions.
inline Scene box_scene(int dimension, Index3 cells, Vec3 spacing = {1e-3, 1e-3, 1e-3}) {
  Scene scene;
  scene.name = scene.title = "box";
  scene.specimen.shape = "box";
  scene.specimen.grid = Grid(dimension, cells, spacing);
  Material material;
  material.name = "soft";
  material.elasticity = ElasticConstants::isotropic(10e3, 0.3);
  scene.materials = {material};
  return scene;
}

inline Material material_of(const ElasticConstants& constants) {
  Material material;
  material.name = "matter";
  material.elasticity = constants;
  return material;
}

inline Material isotropic(double youngs_modulus, double poisson_ratio) {
  return material_of(ElasticConstants::isotropic(youngs_modulus, poisson_ratio));
}

/// Adds a component of a node; sort_prescribed() follows.
inline void add_prescribed(Scene& scene, const Index3& node, int component, double value, bool held) {
  scene.prescribed.push_back({scene.specimen.grid.node(node), component, value, held});
}

inline void sort_prescribed(Scene& scene) {
  std::ranges::sort(scene.prescribed, {}, [](const Prescribed& p) { return std::pair(p.component, p.node); });
}

/// Prescribes `value` for one component of every node of a face of the grid's box.
inline void prescribe_face(Scene& scene, int axis, bool upper, int component, double value, bool held) {
  const Grid& grid = scene.specimen.grid;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    const Index3 at = grid.node_at(node);
    const auto a = static_cast<std::size_t>(axis);
    if (at[a] == (upper ? grid.nodes()[a] - 1 : 0) && scene.specimen.is_node(at))
      scene.prescribed.push_back({node, component, value, held});
  }
  sort_prescribed(scene);
}

inline void hold_face(Scene& scene, int axis, bool upper) {
  for (int component = 0; component < scene.dimension(); ++component)
    prescribe_face(scene, axis, upper, component, 0, true);
}

inline void move_face(Scene& scene, int axis, bool upper, const Vec3& by) {
  for (int component = 0; component < scene.dimension(); ++component)
    prescribe_face(scene, axis, upper, component, by[static_cast<std::size_t>(component)], false);
}

/// Moves all nodes from `low` to `high`, which are included.
inline void move_patch(Scene& scene, const Index3& low, const Index3& high, const Vec3& by) {
  for (int z = low[2]; z <= high[2]; ++z)
    for (int y = low[1]; y <= high[1]; ++y)
      for (int x = low[0]; x <= high[0]; ++x)
        for (int c = 0; c < scene.dimension(); ++c)
          add_prescribed(scene, {x, y, z}, c, by[static_cast<std::size_t>(c)], false);
  sort_prescribed(scene);
}

/// The same traction on every cell's face on one side of the grid's box.
inline void pull_face(Scene& scene, int axis, bool upper, const Vec3& traction) {
  const Grid& grid = scene.specimen.grid;
  const auto a = static_cast<std::size_t>(axis);
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell)
    if (grid.cell_at(cell)[a] == (upper ? grid.cells()[a] - 1 : 0) && scene.specimen.is_matter(cell))
      scene.tractions.push_back({cell, axis, upper, traction});
}

/// Sum of the reactions along a component, of holds or of moves [N].
template<class Answer>
double total_reaction(const Scene& scene, const Answer& answer, int component, bool held) {
  double total = 0;
  for (std::size_t i = 0; i < scene.prescribed.size(); ++i)
    if (scene.prescribed[i].component == component && scene.prescribed[i].held == held)
      total += answer.reaction[i];
  return total;
}

/// Displacement of an affine map u = G x + t at every node, x in the object's frame.
template<class Displacement>
Displacement affine_displacement(const Scene& scene, const std::array<Vec3, 3>& gradient,
                                 const Vec3& shift = {}) {
  Displacement u(scene.specimen.grid);
  for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node) {
    const Vec3 x = scene.specimen.position(scene.specimen.grid.node_at(node));
    for (int b = 0; b < scene.dimension(); ++b) {
      const auto row = static_cast<std::size_t>(b);
      u(b, node) = shift[row];
      for (std::size_t a = 0; a < 3; ++a)
        u(b, node) += gradient[row][a] * x[a];
    }
  }
  return u;
}

} // namespace maille::test
