#include "geometry/pieces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace maille::reader {

namespace {

/// Numbers the pieces of matter, cells joined through faces, from 0; -1 in cells without matter.
std::vector<std::int32_t> number_pieces(const Specimen& body, std::int32_t& n_pieces) {
  const Grid& grid = body.grid;
  std::vector<std::int32_t> piece(static_cast<std::size_t>(grid.n_cells()), -1);
  std::vector<std::int64_t> stack;
  n_pieces = 0;
  for (std::int64_t start = 0; start < grid.n_cells(); ++start) {
    if (!body.is_matter(start) || piece[static_cast<std::size_t>(start)] >= 0)
      continue;
    piece[static_cast<std::size_t>(start)] = n_pieces;
    stack.push_back(start);
    while (!stack.empty()) {
      const Index3 at = grid.cell_at(stack.back());
      stack.pop_back();
      for (int side = 0; side < 2 * grid.dimension(); ++side) {
        Index3 next = at;
        next[static_cast<std::size_t>(side / 2)] += side % 2 ? 1 : -1;
        if (!grid.has_cell(next))
          continue;
        const std::int64_t cell = grid.cell(next);
        if (!body.is_matter(cell) || piece[static_cast<std::size_t>(cell)] >= 0)
          continue;
        piece[static_cast<std::size_t>(cell)] = n_pieces;
        stack.push_back(cell);
      }
    }
    ++n_pieces;
  }
  return piece;
}

/// Pieces that have one of the nodes at a corner.
std::vector<bool> pieces_at(const Specimen& body, const std::vector<std::int32_t>& piece,
                            std::int32_t n_pieces, const std::vector<std::int64_t>& nodes) {
  const Grid& grid = body.grid;
  std::vector<bool> found(static_cast<std::size_t>(n_pieces), false);
  for (const std::int64_t node : nodes) {
    body.for_each_cell_at(grid.node_at(node), [&](std::int64_t cell) {
      found[static_cast<std::size_t>(piece[static_cast<std::size_t>(cell)])] = true;
    });
  }
  return found;
}

std::string name_of(const Scene& scene, std::int32_t number, std::int64_t cells, std::int64_t first_cell) {
  const Vec3 x = scene.specimen.position(
      scene.specimen.grid.node_at(scene.specimen.grid.corner(scene.specimen.grid.cell_at(first_cell), 0)));
  return fmt::format("piece {}: {} cell{} of {} from ({:.4g}, {:.4g}, {:.4g}) m on", number + 1, cells,
                     cells == 1 ? "" : "s", scene.materials[scene.specimen.material(first_cell)].name, x[0],
                     x[1], x[2]);
}

} // namespace

std::int64_t leave_out_loose_pieces(Scene& scene, const std::vector<std::int64_t>& anchors) {
  Specimen& body = scene.specimen;
  if (body.material_id.empty()) // a full box is one piece
    return anchors.empty() ? 0 : body.grid.n_cells();
  std::int32_t n_pieces = 0;
  const auto piece = number_pieces(body, n_pieces);
  const auto kept = pieces_at(body, piece, n_pieces, anchors);
  std::vector<std::int64_t> size(static_cast<std::size_t>(n_pieces), 0),
      first(static_cast<std::size_t>(n_pieces), -1);
  std::int64_t remaining = 0;
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell) {
    if (piece[static_cast<std::size_t>(cell)] < 0)
      continue;
    const auto p = static_cast<std::size_t>(piece[static_cast<std::size_t>(cell)]);
    if (size[p]++ == 0)
      first[p] = cell;
    remaining += kept[p];
  }
  for (std::int32_t p = 0; p < n_pieces; ++p)
    if (const auto i = static_cast<std::size_t>(p); !kept[i])
      scene.left_out.push_back({size[i], name_of(scene, p, size[i], first[i])});
  if (!scene.left_out.empty())
    for (std::size_t cell = 0; cell < piece.size(); ++cell)
      if (piece[cell] >= 0 && !kept[static_cast<std::size_t>(piece[cell])]) {
        body.material_id[cell] = no_material;
        if (!body.label.empty())
          body.label[cell] = 0;
      }
  return remaining;
}

Index3 crop_to_matter(Specimen& body) {
  const Grid& grid = body.grid;
  Index3 low = grid.cells(), high{-1, -1, -1};
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    if (!body.is_matter(cell))
      continue;
    const Index3 at = grid.cell_at(cell);
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], at[a]);
      high[a] = std::max(high[a], at[a]);
    }
  }
  Index3 size{};
  for (std::size_t a = 0; a < 3; ++a)
    size[a] = high[a] - low[a] + 1;
  if (size == grid.cells())
    return low;
  Specimen cropped = body;
  cropped.grid = Grid(grid.dimension(), size, grid.spacing());
  cropped.material_id.clear();
  cropped.fibres.clear();
  cropped.label.clear();
  cropped.tissue.clear();
  cropped.stiffness_ratio.clear();
  for (std::int64_t cell = 0; cell < cropped.grid.n_cells(); ++cell) {
    Index3 at = cropped.grid.cell_at(cell);
    for (std::size_t a = 0; a < 3; ++a)
      at[a] += low[a];
    const auto from = static_cast<std::size_t>(grid.cell(at));
    cropped.material_id.push_back(body.material_id[from]);
    if (!body.fibres.empty())
      cropped.fibres.push_back(body.fibres[from]);
    if (!body.label.empty())
      cropped.label.push_back(body.label[from]);
    if (!body.tissue.empty())
      cropped.tissue.push_back(body.tissue[from]);
    if (!body.stiffness_ratio.empty())
      cropped.stiffness_ratio.push_back(body.stiffness_ratio[from]);
  }
  for (std::size_t a = 0; a < 3; ++a)
    cropped.origin[a] += low[a] * grid.spacing()[a];
  body = std::move(cropped);
  return low;
}

} // namespace maille::reader
