#include "maille/render/deformation.hpp"
#include "maille/base/vectors.hpp"

#include "data/lattice_nodes.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

namespace maille::render {

namespace {

std::array<float, 4> in_floats(const Vec3& x) {
  return {static_cast<float>(x[0]), static_cast<float>(x[1]), static_cast<float>(x[2]), 1.0f};
}

} // namespace

Deformation::Deformation(std::shared_ptr<const Lattice> lattice) : lattice_(std::move(lattice)) {
  nodes_.resize(lattice_->n_nodes());
  for (std::size_t node = 0; node < nodes_.size(); ++node)
    nodes_[node] = in_floats(at_rest(*lattice_, node_at(*lattice_, static_cast<std::int64_t>(node))));
}

void Deformation::set_positions(std::span<const Vec3> positions) {
  if (positions.size() != nodes_.size())
    throw std::invalid_argument("a deformation takes one position a node");
  bool has_changed = false;
  for (std::size_t node = 0; node < nodes_.size(); ++node) {
    const auto position = in_floats(positions[node]);
    has_changed = has_changed || nodes_[node] != position;
    nodes_[node] = position;
  }
  version_ += has_changed ? 1 : 0;
}

void Deformation::set_position(std::int64_t node, const Vec3& position) {
  nodes_[node] = in_floats(position);
  ++version_;
}

Vec3 Deformation::position(std::int64_t node) const {
  const auto& x = nodes_[node];
  return {x[0], x[1], x[2]};
}

std::shared_ptr<const Lattice> lattice_of(const Specimen& body, int margin) {
  auto lattice = std::make_shared<Lattice>();
  const Grid& grid = body.grid;
  for (std::size_t a = 0; a < 3; ++a) {
    // Flat bodies are one cell thick, without margin across.
    const int around = static_cast<int>(a) < grid.dimension() ? margin : 0;
    lattice->cells[a] = grid.cells()[a] + 2 * around;
    lattice->spacing[a] = grid.spacing()[a];
    lattice->origin[a] = body.origin[a] - around * grid.spacing()[a];
  }
  lattice->carries.assign(lattice->n_cells(), 0);
  const Index3 around{(lattice->cells[0] - grid.cells()[0]) / 2, (lattice->cells[1] - grid.cells()[1]) / 2,
                      (lattice->cells[2] - grid.cells()[2]) / 2};
  const Index3 n = lattice->cells;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    if (!body.is_matter(cell))
      continue;
    const Index3 at = grid.cell_at(cell);
    // Every cell within the margin, in Chebyshev distance.
    for (int k = at[2]; k <= at[2] + 2 * around[2]; ++k)
      for (int j = at[1]; j <= at[1] + 2 * around[1]; ++j)
        std::fill_n(lattice->carries.begin() + (at[0] + std::int64_t{n[0]} * (j + std::int64_t{n[1]} * k)),
                    2 * around[0] + 1, std::uint8_t{1});
  }
  return lattice;
}

void carry_along(const Specimen& body, const Displacement& displacement, Deformation& deformation) {
  const Lattice& lattice = deformation.lattice();
  const Grid& grid = body.grid;
  const Index3 around{(lattice.cells[0] - grid.cells()[0]) / 2, (lattice.cells[1] - grid.cells()[1]) / 2,
                      (lattice.cells[2] - grid.cells()[2]) / 2};
  const std::size_t n_nodes = lattice.n_nodes();
  std::vector<Vec3> u(n_nodes, Vec3{});
  std::vector<std::int32_t> ring(n_nodes, -1); ///< steps from the body; -1: not reached
  std::vector<std::int64_t> front, next, outer;
  // A flat body has one layer of nodes, the lattice two.
  const bool is_flat = grid.dimension() < 3;
  for (std::int64_t node = 0; node < lattice.n_nodes(); ++node) {
    const Index3 at = node_at(lattice, node);
    const Index3 own{at[0] - around[0], grid.dimension() < 2 ? 0 : at[1] - around[1],
                     is_flat ? 0 : at[2] - around[2]};
    if (!grid.has_node(own) || !body.is_node(own))
      continue;
    u[node] = displacement.at(grid.node(own));
    ring[node] = 0;
    front.push_back(node);
  }
  for (std::int32_t step = 1; !front.empty(); ++step) {
    next.clear();
    for (const std::int64_t node : front)
      for_each_neighbour(lattice, node, [&](std::int64_t to) {
        if (ring[to] < 0) {
          ring[to] = step;
          next.push_back(to);
        }
      });
    for (const std::int64_t node : next) {
      Vec3 sum{};
      int count = 0;
      for_each_neighbour(lattice, node, [&](std::int64_t from) {
        if (ring[from] == step - 1) {
          sum = plus(sum, u[from]);
          ++count;
        }
      });
      u[node] = times(1.0 / count, sum);
    }
    outer.insert(outer.end(), next.begin(), next.end());
    std::swap(front, next);
  }
  for (int sweep = 0; sweep < 4; ++sweep) // smooths seams between nodes that followed different neighbours
    for (const std::int64_t node : outer) {
      Vec3 sum = u[node];
      int count = 1;
      for_each_neighbour(lattice, node, [&](std::int64_t from) {
        sum = plus(sum, u[from]);
        ++count;
      });
      u[node] = times(1.0 / count, sum);
    }
  std::vector<Vec3> positions(n_nodes);
  for (std::int64_t node = 0; node < lattice.n_nodes(); ++node)
    positions[node] = plus(at_rest(lattice, node_at(lattice, node)), u[node]);
  deformation.set_positions(positions);
}

} // namespace maille::render
