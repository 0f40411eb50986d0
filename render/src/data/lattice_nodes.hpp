#pragma once
/// Positions and neighbours of the nodes of a lattice, at rest.

#include "maille/render/deformation.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace maille::render {

inline Index3 node_at(const Lattice& lattice, std::int64_t node) {
  const Index3 n = lattice.nodes();
  return {static_cast<int>(node % n[0]), static_cast<int>(node / n[0] % n[1]),
          static_cast<int>(node / (std::int64_t{n[0]} * n[1]))};
}

inline Vec3 at_rest(const Lattice& lattice, const Index3& at) {
  return {lattice.origin[0] + at[0] * lattice.spacing[0], lattice.origin[1] + at[1] * lattice.spacing[1],
          lattice.origin[2] + at[2] * lattice.spacing[2]};
}

/// Calls visit(neighbour) for the neighbours of a node along the axes.
template<class Visit>
void for_each_neighbour(const Lattice& lattice, std::int64_t node, Visit&& visit) {
  const Index3 n = lattice.nodes(), at = node_at(lattice, node);
  const std::array<std::int64_t, 3> stride{1, n[0], std::int64_t{n[0]} * n[1]};
  for (std::size_t a = 0; a < 3; ++a) {
    if (at[a] > 0)
      visit(node - stride[a]);
    if (at[a] + 1 < n[a])
      visit(node + stride[a]);
  }
}

} // namespace maille::render
