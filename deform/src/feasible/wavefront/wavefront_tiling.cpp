#include "feasible/wavefront/wavefront_tiling.hpp"

#include <algorithm>

namespace maille::deform {

namespace {

/// Bit i: whether the cell at (x + i, y, z) is matter; cells outside the grid are not.
std::uint32_t matter_bits(const Specimen& body, int x, int y, int z, int n) {
  const Index3& cells = body.grid.cells();
  if (y < 0 || z < 0 || y >= cells[1] || z >= cells[2])
    return 0;
  const std::int64_t row = body.grid.cell({0, y, z});
  std::uint32_t bits = 0;
  for (int i = std::max(0, -x); i < std::min(n, cells[0] - x); ++i)
    bits |= static_cast<std::uint32_t>(body.is_matter(row + x + i)) << i;
  return bits;
}

/// Layers of a tile: 1, 2, 4 or 8, so that thin bodies use no more.
int layers_of(const Grid& grid) {
  int layers = 1;
  while (layers < std::min(tile_edge, grid.nodes()[2]))
    layers *= 2;
  return layers;
}

Index3 tiles_along(const Grid& grid) {
  Index3 n{};
  for (std::size_t a = 0; a < 3; ++a)
    n[a] = (grid.nodes()[a] + tile_edge - 1) / tile_edge;
  return n;
}

std::int64_t product(const Index3& n) {
  return std::int64_t{1} * n[0] * n[1] * n[2];
}

} // namespace

Tiling::Tiling(const Specimen& specimen)
    : specimen_(&specimen), layers_(layers_of(specimen.grid)), n_along_(tiles_along(specimen.grid)) {
  tile_at_.reserve(product(n_along_));
  for (int z = 0; z < n_along_[2]; ++z)
    for (int y = 0; y < n_along_[1]; ++y)
      for (int x = 0; x < n_along_[0]; ++x)
        tile_at_.push_back(find_nodes({x * tile_edge, y * tile_edge, z * tile_edge}) ? n_tiles() - 1 : -1);
  base_.shrink_to_fit();
  node_bits_.shrink_to_fit();

  neighbours_.resize(base_.size());
  const std::array<std::int64_t, 3> stride{1, n_along_[0], std::int64_t{1} * n_along_[0] * n_along_[1]};
  for (std::int64_t at = 0; at < static_cast<std::int64_t>(tile_at_.size()); ++at) {
    const std::int32_t tile = tile_at_[at];
    if (tile < 0)
      continue;
    for (std::size_t a = 0; a < 3; ++a) {
      const auto along = at / stride[a] % n_along_[a];
      auto& of_tile = neighbours_[tile];
      of_tile[2 * a] = along > 0 ? tile_at_[at - stride[a]] : -1;
      of_tile[2 * a + 1] = along + 1 < n_along_[a] ? tile_at_[at + stride[a]] : -1;
    }
  }
}

/// Adds the tile at `base` if it holds nodes.
bool Tiling::find_nodes(const Index3& base) {
  // A node is one if any cell around it is matter: neighbouring bits, rows and layers are joined by or.
  std::array<std::array<std::uint32_t, tile_edge>, tile_edge + 1> rows{};
  for (int z = 0; z <= layers_; ++z) {
    std::array<std::uint32_t, tile_edge + 1> of_cells{};
    for (int y = 0; y <= tile_edge; ++y) {
      const std::uint32_t bits =
          matter_bits(*specimen_, base[0] - 1, base[1] + y - 1, base[2] + z - 1, tile_edge + 1);
      of_cells[y] = (bits | bits >> 1) & 0xffU;
    }
    for (std::size_t y = 0; y < tile_edge; ++y)
      rows[z][y] = of_cells[y] | of_cells[y + 1];
  }
  std::array<std::uint64_t, tile_edge> layers{};
  std::uint64_t any = 0;
  // In 1D cells have corners on a second row, which are no nodes.
  const auto n_rows = static_cast<std::size_t>(std::min(tile_edge, specimen_->grid.nodes()[1] - base[1]));
  for (std::size_t z = 0; z < static_cast<std::size_t>(layers_); ++z) {
    for (std::size_t y = 0; y < n_rows; ++y)
      layers[z] |= std::uint64_t{rows[z][y] | rows[z + 1][y]} << (tile_edge * y);
    any |= layers[z];
  }
  if (any == 0)
    return false;
  base_.push_back(base);
  node_bits_.insert(node_bits_.end(), layers.begin(), layers.begin() + layers_);
  return true;
}

TilePlace Tiling::place(std::int64_t node) const {
  const Index3 at = specimen_->grid.node_at(node);
  const int x = at[0] / tile_edge, y = at[1] / tile_edge, z = at[2] / tile_edge;
  const auto tile = static_cast<std::size_t>(x + n_along_[0] * (y + std::int64_t{1} * n_along_[1] * z));
  return {tile_at_[tile],
          at[0] % tile_edge + tile_edge * (at[1] % tile_edge) + tile_layer * (at[2] % tile_edge)};
}

int Tiling::volume_for(const Specimen& specimen) {
  return layers_of(specimen.grid) * tile_layer;
}

bool Tiling::has(std::int64_t node) const {
  const Index3 at = specimen_->grid.node_at(node);
  const int x = at[0] / tile_edge, y = at[1] / tile_edge, z = at[2] / tile_edge;
  return tile_at_[x + n_along_[0] * (y + std::int64_t{1} * n_along_[1] * z)] >= 0 && is_node(place(node));
}

std::int64_t Tiling::n_places(const Specimen& specimen) {
  return product(tiles_along(specimen.grid));
}

std::int64_t Tiling::n_tiles_of(const Specimen& specimen) {
  const Index3& cells = specimen.grid.cells();
  const Index3 along = tiles_along(specimen.grid);
  if (specimen.n_matter_cells() == specimen.grid.n_cells())
    return product(along);
  std::vector<bool> has_nodes(product(along));
  // A cell's nodes are at its lower and its upper corners.
  const auto last = [](int cell, int tiles) { return std::min((cell + 1) / tile_edge, tiles - 1); };
  std::int64_t cell = 0;
  for (int z = 0; z < cells[2]; ++z)
    for (int y = 0; y < cells[1]; ++y)
      for (int x = 0; x < cells[0]; ++x, ++cell)
        if (specimen.is_matter(cell))
          for (int k = z / tile_edge; k <= last(z, along[2]); ++k)
            for (int j = y / tile_edge; j <= last(y, along[1]); ++j)
              for (int i = x / tile_edge; i <= last(x, along[0]); ++i)
                has_nodes[i + along[0] * (j + std::int64_t{1} * along[1] * k)] = true;
  return std::ranges::count(has_nodes, true);
}

} // namespace maille::deform
