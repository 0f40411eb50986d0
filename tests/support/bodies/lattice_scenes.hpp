#pragma once
/// Small bodies with limits, holds and moves, for tests of neighbour limits.

#include "maille/scene/answer.hpp"

#include <algorithm>
#include <initializer_list>
#include <random>

namespace maille::test {

/// Equal limits along all axes.
inline NeighbourLimits even_limits(double stretch, double compress, double shear) {
  NeighbourLimits limits;
  limits.stretch.fill(stretch);
  limits.compress.fill(compress);
  for (auto& row : limits.shear)
    row.fill(shear);
  return limits;
}

/// A box of `cells` (one number per dimension) with unit spacing and given limits, without holds or moves.
inline Scene lattice_box(std::initializer_list<int> cells, const NeighbourLimits& limits) {
  Index3 n{1, 1, 1};
  std::ranges::copy(cells, n.begin());
  Scene scene;
  scene.name = "lattice_box";
  scene.specimen.shape = "box";
  scene.specimen.grid = Grid(int(cells.size()), n, {1, 1, 1});
  Material material;
  material.name = "lattice";
  material.elasticity = ElasticConstants::isotropic(1e4, 0.3);
  scene.materials = {material};
  scene.limits.from = LimitSource::given;
  scene.limits.given = limits;
  return scene;
}

/// A copy of the scene with given limits.
inline Scene with_limits(Scene scene, const NeighbourLimits& limits) {
  scene.limits.from = LimitSource::given;
  scene.limits.given = limits;
  return scene;
}

inline void prescribe(Scene& scene, std::int64_t node, int component, double value, bool held) {
  auto& list = scene.prescribed;
  std::erase_if(list, [&](const Prescribed& p) { return p.node == node && p.component == component; });
  list.push_back({node, component, value, held});
  std::ranges::sort(list, [](const Prescribed& a, const Prescribed& b) {
    return std::pair(a.component, a.node) < std::pair(b.component, b.node);
  });
}

inline void move(Scene& scene, const Index3& at, const Vec3& by) {
  for (int b = 0; b < scene.dimension(); ++b)
    prescribe(scene, scene.specimen.grid.node(at), b, by[std::size_t(b)], false);
}

inline void hold(Scene& scene, const Index3& at) {
  for (int b = 0; b < scene.dimension(); ++b)
    prescribe(scene, scene.specimen.grid.node(at), b, 0, true);
}

/// A chain held at its lower end and pulled at the upper one: cells of two materials with different limits.
inline Scene pulled_chain(const std::vector<std::uint8_t>& materials, const NeighbourLimits& first,
                          const NeighbourLimits& second, double by) {
  Scene scene = lattice_box({int(materials.size())}, {});
  scene.limits.from = LimitSource::material;
  scene.materials.push_back(scene.materials[0]);
  scene.materials[0].limits = first;
  scene.materials[1].limits = second;
  scene.specimen.material_id.assign(materials.begin(), materials.end());
  hold(scene, {0, 0, 0});
  move(scene, {int(materials.size()), 0, 0}, {by, 0, 0});
  return scene;
}

/// A sheet of 9 x 9 cells with a slot from the top to its third row: paths around it turn back.
inline Scene slotted_sheet() {
  Scene scene = lattice_box({9, 9}, even_limits(1.125, 0.875, 0.125));
  scene.specimen.material_id.assign(81, 0);
  for (int y = 2; y < 9; ++y)
    scene.specimen.material_id[std::size_t(4 + 9 * y)] = no_material;
  return scene;
}

/// The nodes of the body on the lower or upper face of the grid along `axis`.
inline std::vector<Index3> face(const Scene& scene, int axis, bool upper) {
  const Grid& grid = scene.specimen.grid;
  const auto a = std::size_t(axis);
  std::vector<Index3> nodes;
  for (std::int64_t n = 0; n < grid.n_nodes(); ++n) {
    const Index3 at = grid.node_at(n);
    if (at[a] == (upper ? grid.nodes()[a] - 1 : 0) && scene.specimen.is_node(at))
      nodes.push_back(at);
  }
  return nodes;
}

/// A random body of up to 5 cells along each axis: holes, three materials with different limits (some rigid),
/// several holds and moves. Values are not dyadic; a third of the requests is infeasible.
inline Scene random_body(std::mt19937& random) {
  const auto below = [&](int n) { return int(random() % unsigned(n)); };
  std::uniform_real_distribution<double> uniform(0, 1);
  const int dimension = 1 + below(3);
  Scene scene = lattice_box({1}, {});
  Index3 cells{1, 1, 1};
  for (int a = 0; a < dimension; ++a)
    cells[std::size_t(a)] = 2 + below(dimension == 3 ? 2 : 4);
  scene.specimen.grid = Grid(dimension, cells, {0.5 + uniform(random), 0.5 + uniform(random), 1});
  scene.limits.from = LimitSource::material;
  scene.materials.assign(3, scene.materials[0]);
  for (Material& material : scene.materials) {
    NeighbourLimits limits;
    for (std::size_t a = 0; a < 3; ++a) {
      limits.stretch[a] = 1 + (below(5) == 0 ? 0 : 0.5 * uniform(random));
      limits.compress[a] = 1 - (below(5) == 0 ? 0 : 0.5 * uniform(random));
      for (std::size_t b = 0; b < 3; ++b)
        limits.shear[a][b] = below(5) == 0 ? 0 : 0.5 * uniform(random);
    }
    material.limits = limits;
  }
  auto& kinds = scene.specimen.material_id;
  kinds.resize(std::size_t(scene.specimen.grid.n_cells()));
  for (auto& kind : kinds)
    kind = below(4) == 0 ? no_material : std::uint8_t(below(3));
  kinds[std::size_t(below(int(kinds.size())))] = 0;

  std::vector<std::int64_t> nodes;
  for (std::int64_t n = 0; n < scene.specimen.grid.n_nodes(); ++n)
    if (scene.specimen.is_node(scene.specimen.grid.node_at(n)))
      nodes.push_back(n);
  const auto any_node = [&] { return nodes[std::size_t(below(int(nodes.size())))]; };
  const int n_moves = 1 + below(4), n_holds = below(3);
  const double size = below(3) == 0 ? 4 : 0.4;
  for (int i = 0; i < n_moves; ++i)
    prescribe(scene, any_node(), below(dimension), size * (uniform(random) - 0.5), false);
  for (int i = 0; i < n_holds; ++i)
    prescribe(scene, any_node(), below(dimension), 0, true);
  return scene;
}

inline int below(std::mt19937& random, int n) {
  return int(random() % unsigned(n));
}

/// Limits in multiples of 1/16, some of them 0 (rigid), different for every direction.
inline NeighbourLimits random_dyadic_limits(std::mt19937& random) {
  NeighbourLimits given;
  for (std::size_t a = 0; a < 3; ++a) {
    given.stretch[a] = 1 + below(random, 9) / 16.0;
    given.compress[a] = 1 - below(random, 9) / 16.0;
    for (std::size_t b = 0; b < 3; ++b)
      given.shear[a][b] = below(random, 9) / 16.0;
  }
  return given;
}

/// A box of up to 3000 nodes, often longer along one axis than a block of vectors.
inline Scene random_box(std::mt19937& random, int dimension) {
  Scene scene = lattice_box({1}, random_dyadic_limits(random));
  Index3 cells{1, 1, 1};
  for (int a = 0; a < dimension; ++a)
    cells[std::size_t(a)] = 1 + below(random, dimension == 1 ? 90 : dimension == 2 ? 30 : 9);
  if (dimension > 1)
    cells[std::size_t(below(random, dimension))] = 1 + below(random, 50);
  scene.specimen.grid = Grid(dimension, cells, {1, 0.5, 2});
  return scene;
}

inline Index3 random_node(std::mt19937& random, const Grid& grid) {
  return grid.node_at(std::int64_t(random() % std::uint64_t(grid.n_nodes())));
}

/// A displacement in multiples of 1/16, up to `largest`.
inline Vec3 random_dyadic(std::mt19937& random, int largest) {
  Vec3 by{};
  for (double& component : by)
    component = (below(random, 32 * largest + 1) - 16 * largest) / 16.0;
  return by;
}

} // namespace maille::test
