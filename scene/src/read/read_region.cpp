#include "read/reader.hpp"

namespace maille::reader {

namespace {

constexpr const char* wanted_region =
    "a face (\"x-\", \"x+\", ...) or { box = [[x0, y0, z0], [x1, y1, z1]] }";

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

std::optional<Region> read_region(TableReader& table, int dimension) {
  const toml::node* node = table.require("where", wanted_region);
  if (!node)
    return std::nullopt;
  if (const auto* text = node->as_string()) {
    auto region = Region::face(text->get(), dimension);
    if (!region)
      table.fault("where", wanted_region, describe(*node));
    return region;
  }
  const auto* values = node->as_table();
  if (!values) {
    table.fault("where", wanted_region, describe(*node));
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
  return Region::box(*first, *second);
}

} // namespace maille::reader
