#include "conditions/region.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace maille::reader {

std::optional<Region> Region::face(std::string_view name, int dimension) {
  const int n_axes = dimension > 0 ? dimension : 3;
  if (name.size() != 2 || name[0] < 'x' || name[0] >= 'x' + n_axes || (name[1] != '-' && name[1] != '+'))
    return std::nullopt;
  Region region(Kind::face);
  region.face_axis_ = name[0] - 'x';
  region.upper_ = name[1] == '+';
  return region;
}

Region Region::box(const Vec3& first, const Vec3& second) {
  Region region(Kind::box);
  for (std::size_t a = 0; a < 3; ++a) {
    region.low_[a] = std::min(first[a], second[a]);
    region.high_[a] = std::max(first[a], second[a]);
  }
  return region;
}

Region Region::numbered(std::vector<std::int64_t> nodes) {
  Region region(Kind::numbered);
  std::ranges::sort(nodes);
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  region.numbers_ = std::move(nodes);
  return region;
}

bool Region::contains(const Specimen& body, const Index3& node) const {
  if (kind_ == Kind::numbered)
    return std::ranges::binary_search(numbers_, body.grid.node(node));
  if (kind_ == Kind::face) {
    const auto a = static_cast<std::size_t>(face_axis_);
    return node[a] == (upper_ ? body.grid.nodes()[a] - 1 : 0);
  }
  const Vec3 x = body.position(node);
  for (std::size_t a = 0; a < static_cast<std::size_t>(body.grid.dimension()); ++a) {
    // A corner that a person writes as 0.3 and the grid as 3 * 0.1 is the same corner.
    const double tolerance = 1e-6 * body.grid.spacing()[a];
    if (x[a] < low_[a] - tolerance || x[a] > high_[a] + tolerance)
      return false;
  }
  return true;
}

bool Region::contains_cell(const Specimen& body, std::int64_t cell) const {
  const Index3 at = body.grid.cell_at(cell);
  for (int corner = 0; corner < body.grid.corners_per_cell(); ++corner)
    if (!contains(body, body.grid.node_at(body.grid.corner(at, corner))))
      return false;
  return true;
}

std::vector<std::int64_t> Region::nodes(const Specimen& body) const {
  if (kind_ == Kind::numbered) {
    std::vector<std::int64_t> selected;
    std::ranges::copy_if(numbers_, std::back_inserter(selected),
                         [&](std::int64_t node) { return body.is_node(body.grid.node_at(node)); });
    return selected;
  }
  // Only the slab of a face, or the index range of a box, is looked at: scenes may have 10^8 nodes.
  Index3 first{0, 0, 0}, last = body.grid.nodes();
  for (std::size_t a = 0; a < static_cast<std::size_t>(body.grid.dimension()); ++a) {
    if (kind_ == Kind::face && face_axis_ == static_cast<int>(a)) {
      first[a] = upper_ ? body.grid.nodes()[a] - 1 : 0;
      last[a] = first[a] + 1;
    } else if (kind_ == Kind::box) {
      const double h = body.grid.spacing()[a];
      const double n = body.grid.nodes()[a];
      first[a] = static_cast<int>(std::clamp(std::floor((low_[a] - body.origin[a]) / h) - 1, 0.0, n));
      last[a] = static_cast<int>(std::clamp(std::ceil((high_[a] - body.origin[a]) / h) + 2, 0.0, n));
    }
  }
  std::vector<std::int64_t> selected;
  for (int k = first[2]; k < last[2]; ++k)
    for (int j = first[1]; j < last[1]; ++j)
      for (int i = first[0]; i < last[0]; ++i)
        if (const Index3 at{i, j, k}; contains(body, at) && body.is_node(at))
          selected.push_back(body.grid.node(at));
  return selected;
}

std::vector<FaceLoad> Region::faces(const Specimen& body) const {
  const Grid& grid = body.grid;
  std::vector<FaceLoad> selected;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    if (!body.is_matter(cell))
      continue;
    const Index3 at = grid.cell_at(cell);
    for (int side = 0; side < 2 * grid.dimension(); ++side) {
      const int axis = side / 2;
      const bool upper = side % 2;
      Index3 beyond = at;
      beyond[static_cast<std::size_t>(axis)] += upper ? 1 : -1;
      if (grid.has_cell(beyond) && body.is_matter(grid.cell(beyond)))
        continue;
      if (kind_ == Kind::face && (axis != face_axis_ || upper != upper_))
        continue;
      bool whole = true;
      for (int corner = 0; whole && corner < grid.corners_per_cell(); ++corner)
        if (((corner >> axis) & 1) == (upper ? 1 : 0))
          whole = contains(body, grid.node_at(grid.corner(at, corner)));
      if (whole)
        selected.push_back({cell, axis, upper, {}});
    }
  }
  return selected;
}

} // namespace maille::reader
