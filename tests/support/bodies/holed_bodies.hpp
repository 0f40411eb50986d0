#pragma once
/// Random bodies of several tiles for tests of propagation: holes, islands, bridges, many materials.

#include "support/bodies/lattice_scenes.hpp"
#include "support/dice.hpp"

namespace maille::test {

/// Limits that differ between axes and components; every fifth slack is zero, every tenth is wide.
inline NeighbourLimits uneven_limits(Dice& dice) {
  NeighbourLimits limits;
  const auto slack = [&] {
    const int kind = dice.below(10);
    return kind < 2 ? 0.0 : kind == 2 ? 0.9 : 0.3 * dice.uniform();
  };
  for (std::size_t a = 0; a < 3; ++a) {
    limits.stretch[a] = 1 + slack();
    limits.compress[a] = 1 - slack();
    for (std::size_t b = 0; b < 3; ++b)
      limits.shear[a][b] = slack();
  }
  return limits;
}

inline std::vector<std::int64_t> matter_nodes(const Scene& scene) {
  std::vector<std::int64_t> nodes;
  for (std::int64_t n = 0; n < scene.specimen.grid.n_nodes(); ++n)
    if (scene.specimen.is_node(scene.specimen.grid.node_at(n)))
      nodes.push_back(n);
  return nodes;
}

/// Random handles and holds, up and down; displacements from a link's slack to far beyond the body's.
inline void prescribe_at_random(Scene& scene, Dice& dice) {
  scene.prescribed.clear();
  const std::vector<std::int64_t> nodes = matter_nodes(scene);
  const auto any_node = [&] { return nodes[std::size_t(dice.below(int(nodes.size())))]; };
  const double size = std::array{0.3, 3.0, 30.0}[std::size_t(dice.below(3))];
  const int n_moves = 1 + dice.below(6), n_holds = dice.below(3);
  for (int i = 0; i < n_moves; ++i)
    prescribe(scene, any_node(), dice.below(scene.dimension()), size * (2 * dice.uniform() - 1), false);
  for (int i = 0; i < n_holds; ++i)
    prescribe(scene, any_node(), dice.below(scene.dimension()), 0, true);
}

/// A body in one, two or three dimensions, up to 40, 24 x 24 or 17 x 17 x 17 cells: solid, with holes that
/// form islands, bridges of one cell and single cells, or a maze of walls; one material, several, or fibres
/// per cell that give every cell its own kind.
inline Scene holed_body(std::mt19937& random) {
  Dice dice{random};
  const int dimension = 1 + dice.below(3);
  Scene scene = lattice_box({1}, {});
  Index3 cells{1, 1, 1};
  for (int a = 0; a < dimension; ++a)
    cells[std::size_t(a)] = 1 + dice.below(std::array{40, 24, 17}[std::size_t(dimension - 1)]);
  scene.specimen.grid = Grid(dimension, cells, {0.5 + dice.uniform(), 0.5 + dice.uniform(), 1});
  scene.limits.from = LimitSource::material;
  const int n_materials = dice.below(3) == 0 ? 1 : 3;
  scene.materials.assign(std::size_t(n_materials), scene.materials[0]);
  for (Material& material : scene.materials)
    material.limits = uneven_limits(dice);

  const auto n_cells = std::size_t(scene.specimen.grid.n_cells());
  auto& kinds = scene.specimen.material_id;
  kinds.resize(n_cells);
  const int shape = dice.below(3);
  const int holes = shape == 1 ? 30 + dice.below(40) : 0; // percent
  for (std::size_t i = 0; i < n_cells; ++i) {
    const Index3 at = scene.specimen.grid.cell_at(std::int64_t(i));
    const bool is_wall = shape == 2 && at[0] % 3 == 2 && at[1] != (at[0] % 2 == 0 ? 0 : cells[1] - 1);
    const bool is_hole = is_wall || dice.below(100) < holes;
    kinds[i] = is_hole ? no_material : std::uint8_t(dice.below(n_materials));
  }
  kinds[std::size_t(dice.below(int(n_cells)))] = 0;
  if (dice.below(4) == 0)
    for (std::size_t i = 0; i < n_cells; ++i) {
      Vec3 f{dice.uniform() + 0.01, dimension > 1 ? dice.uniform() : 0, dimension > 2 ? dice.uniform() : 0};
      const double length = std::hypot(f[0], f[1], f[2]);
      scene.specimen.fibres.push_back({float(f[0] / length), float(f[1] / length), float(f[2] / length)});
    }
  prescribe_at_random(scene, dice);
  return scene;
}

} // namespace maille::test
