#include "data/lattice_nodes.hpp"

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

namespace maille::render {

namespace {

/// Cells of the lattice around the body, as in lattice_of().
constexpr int margin = 1;

/// A body node among the fine nodes nearest to a coarse one, the centre first; -1 without one.
std::int64_t node_near(const Specimen& body, const Index3& middle, int stride) {
  const Grid& grid = body.grid;
  std::int64_t best = -1;
  int least = 3 * stride * stride;
  const int reach = stride / 2;
  for (int k = -reach; k <= reach; ++k)
    for (int j = -reach; j <= reach; ++j)
      for (int i = -reach; i <= reach; ++i) {
        const int squared = i * i + j * j + k * k;
        const Index3 at{middle[0] + i, middle[1] + j, middle[2] + k};
        if (squared < least && grid.has_node(at) && body.is_node(at)) {
          least = squared;
          best = grid.node(at);
        }
      }
  return best;
}

} // namespace

CoarseCarrier::CoarseCarrier(const Specimen& body, int stride) {
  const Grid& grid = body.grid;
  if (grid.dimension() != 3 || stride < 2)
    throw std::invalid_argument("CoarseCarrier: a body in three dimensions, and every second node at most");
  auto lattice = std::make_shared<Lattice>();
  for (std::size_t a = 0; a < 3; ++a) {
    lattice->cells[a] = (grid.cells()[a] + 2 * margin + stride - 1) / stride;
    lattice->spacing[a] = stride * grid.spacing()[a];
    lattice->origin[a] = body.origin[a] - margin * grid.spacing()[a];
  }
  const Index3 n_cells = lattice->cells;
  lattice->carries.assign(lattice->n_cells(), 0);
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    if (!body.is_matter(cell))
      continue;
    const Index3 at = grid.cell_at(cell); // with a cell around it: `at` to `at + 2` of the fine lattice
    for (int k = at[2] / stride; k <= (at[2] + 2 * margin) / stride; ++k)
      for (int j = at[1] / stride; j <= (at[1] + 2 * margin) / stride; ++j)
        for (int i = at[0] / stride; i <= (at[0] + 2 * margin) / stride; ++i)
          lattice->carries[i + std::int64_t{n_cells[0]} * (j + std::int64_t{n_cells[1]} * k)] = 1;
  }
  // Nodes near a node of the body take its displacement, the others that of their neighbours.
  const std::size_t n = lattice->n_nodes();
  node_of_.assign(n, -1);
  at_rest_.resize(n);
  std::vector<std::int64_t> front, next;
  for (std::int64_t node = 0; node < lattice->n_nodes(); ++node) {
    const Index3 at = node_at(*lattice, node);
    at_rest_[node] = at_rest(*lattice, at);
    const Index3 fine{stride * at[0] - margin, stride * at[1] - margin, stride * at[2] - margin};
    node_of_[node] = node_near(body, fine, stride);
    if (node_of_[node] >= 0)
      front.push_back(node);
  }
  while (!front.empty()) {
    next.clear();
    for (const std::int64_t node : front)
      for_each_neighbour(*lattice, node, [&](std::int64_t to) {
        std::int64_t& of = node_of_[to];
        if (of < 0) {
          of = node_of_[node];
          next.push_back(to);
        }
      });
    std::swap(front, next);
  }
  lattice_ = std::move(lattice);
  positions_ = at_rest_;
}

void CoarseCarrier::carry(const Displacement& displacement, Deformation& deformation) {
  for (std::size_t node = 0; node < at_rest_.size(); ++node)
    if (node_of_[node] >= 0)
      for (std::size_t a = 0; a < 3; ++a)
        positions_[node][a] = at_rest_[node][a] + displacement(a, node_of_[node]);
  deformation.set_positions(positions_);
}

} // namespace maille::render
