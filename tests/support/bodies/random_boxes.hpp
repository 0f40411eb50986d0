#pragma once
/// Random homogeneous bodies whose numbers are dyadic, so that all sums are exact and bits can be compared.

#include "support/bodies/lattice_scenes.hpp"

namespace maille::tests {

inline int below(std::mt19937& random, int n) {
  return static_cast<int>(random() % static_cast<unsigned>(n));
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
    cells[static_cast<std::size_t>(a)] = 1 + below(random, dimension == 1 ? 90 : dimension == 2 ? 30 : 9);
  if (dimension > 1)
    cells[static_cast<std::size_t>(below(random, dimension))] = 1 + below(random, 50);
  scene.specimen.grid = Grid(dimension, cells, {1, 0.5, 2});
  return scene;
}

inline Index3 random_node(std::mt19937& random, const Grid& grid) {
  return grid.node_at(static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(grid.n_nodes())));
}

/// A displacement in multiples of 1/16, up to `largest`.
inline Vec3 random_dyadic(std::mt19937& random, int largest) {
  Vec3 by{};
  for (double& component : by)
    component = (below(random, 32 * largest + 1) - 16 * largest) / 16.0;
  return by;
}

} // namespace maille::tests
