#include "read/reader.hpp"

#include <cmath>

namespace maille::reader {

namespace {

constexpr const char* wanted = "a face (\"x-\", \"x+\", ...) or { box = [[x0, y0, z0], [x1, y1, z1]] }";

/// One corner of a box: a quantity for each axis of the scene, or three.
std::optional<Vec3> read_corner(const toml::node& node, const std::string& path, int dimension,
                                FaultList& faults) {
  const auto* list = node.as_array();
  const bool fits =
      list && !list->empty() && list->size() <= 3 &&
      (dimension == 0 || list->size() == static_cast<std::size_t>(dimension) || list->size() == 3);
  if (!fits) {
    faults.add(line_of(node), path, "the coordinates of two opposite corners", describe(node));
    return std::nullopt;
  }
  Vec3 corner{};
  bool good = true;
  for (std::size_t a = 0; a < list->size(); ++a) {
    const auto value = read_quantity(*list->get(a), path, Dimension::length, faults);
    good = good && value;
    corner[a] = value.value_or(0);
  }
  return good ? std::optional(corner) : std::nullopt;
}

} // namespace

std::optional<Region> Region::read(TableReader& table, int dimension) {
  const int n_axes = dimension > 0 ? dimension : 3;
  const toml::node* node = table.require("where", wanted);
  if (!node)
    return std::nullopt;
  Region region;
  if (const auto* text = node->as_string()) {
    const std::string& face = text->get();
    const bool good =
        face.size() == 2 && face[0] >= 'x' && face[0] < 'x' + n_axes && (face[1] == '-' || face[1] == '+');
    if (!good) {
      table.fault("where", wanted, describe(*node));
      return std::nullopt;
    }
    region.face_axis_ = face[0] - 'x';
    region.upper_ = face[1] == '+';
    return region;
  }
  const auto* values = node->as_table();
  if (!values) {
    table.fault("where", wanted, describe(*node));
    return std::nullopt;
  }
  TableReader reader(*values, table.path_of("where"), table.faults());
  const toml::node* box = reader.require("box", "two opposite corners");
  reader.finish();
  const auto* corners = box ? box->as_array() : nullptr;
  if (box && (!corners || corners->size() != 2))
    reader.fault("box", "two opposite corners", describe(*box));
  if (!corners || corners->size() != 2)
    return std::nullopt;
  const auto first = read_corner(*corners->get(0), reader.path_of("box"), dimension, table.faults());
  const auto second = read_corner(*corners->get(1), reader.path_of("box"), dimension, table.faults());
  if (!first || !second)
    return std::nullopt;
  for (std::size_t a = 0; a < 3; ++a) {
    region.low_[a] = std::min((*first)[a], (*second)[a]);
    region.high_[a] = std::max((*first)[a], (*second)[a]);
  }
  return region;
}

bool Region::contains(const Specimen& body, const Index3& node) const {
  if (face_axis_ >= 0) {
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
  // Only the slab of a face, or the index range of a box, is looked at: scenes may have 10^8 nodes.
  Index3 first{0, 0, 0}, last = body.grid.nodes();
  for (std::size_t a = 0; a < static_cast<std::size_t>(body.grid.dimension()); ++a) {
    if (face_axis_ == static_cast<int>(a)) {
      first[a] = upper_ ? body.grid.nodes()[a] - 1 : 0;
      last[a] = first[a] + 1;
    } else if (face_axis_ < 0) {
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
      if (face_axis_ >= 0 && (axis != face_axis_ || upper != upper_))
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
