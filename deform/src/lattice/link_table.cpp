#include "lattice/link_table.hpp"

#include <algorithm>

namespace maille::deform {

LinkTable::LinkTable(const Scene& scene, const LinkLimits& limits)
    : below_(static_cast<std::size_t>(scene.dimension())),
      above_(static_cast<std::size_t>(scene.dimension())) {
  const Specimen& body = scene.specimen;
  number_nodes(body);
  first_.reserve(grid_node_.size() + 1);
  const auto n_entries = static_cast<std::size_t>(2 * body.n_matter_links());
  neighbour_.reserve(n_entries);
  direction_.reserve(n_entries);
  for (auto* const bounds : {&below_, &above_})
    for (auto& component : *bounds)
      component.reserve(n_entries);
  first_.push_back(0);
  for (const std::int64_t node : grid_node_) {
    add_links(body, limits, body.grid.node_at(node));
    first_.push_back(static_cast<std::int32_t>(neighbour_.size()));
  }
}

void LinkTable::number_nodes(const Specimen& body) {
  grid_node_.reserve(body.n_matter_nodes());
  for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node)
    if (body.is_node(body.grid.node_at(node)))
      grid_node_.push_back(node);
}

void LinkTable::add_links(const Specimen& body, const LinkLimits& limits, const Index3& at) {
  for (int axis = 0; axis < dimension(); ++axis)
    for (const bool upper : {false, true}) {
      const auto a = static_cast<std::size_t>(axis);
      Index3 near = at, other = at;
      other[a] += upper ? 1 : -1;
      if (!upper)
        near = other;
      if (!body.grid.has_node(other))
        continue;
      const auto link = limits.intervals(near, axis);
      if (!link)
        continue;
      neighbour_.push_back(body_node(body.grid.node(other)));
      direction_.push_back(static_cast<std::uint8_t>(2 * axis + (upper ? 1 : 0)));
      // low <= u_far - u_near <= high, seen from the near end or from the far one
      for (std::size_t b = 0; b < below_.size(); ++b) {
        below_[b].push_back(upper ? -link->high[b] : link->low[b]);
        above_[b].push_back(upper ? -link->low[b] : link->high[b]);
      }
    }
}

std::int32_t LinkTable::body_node(std::int64_t grid_node) const {
  const auto place = std::ranges::lower_bound(grid_node_, grid_node);
  return static_cast<std::int32_t>(place - grid_node_.begin());
}

List<double> LinkTable::gather(const Displacement& displacement, int component) const {
  List<double> values;
  values.reserve(grid_node_.size());
  for (const std::int64_t node : grid_node_)
    values.push_back(displacement(component, node));
  return values;
}

void LinkTable::scatter(const List<double>& values, int component, Displacement& displacement) const {
  for (std::size_t i = 0; i < grid_node_.size(); ++i)
    displacement(component, grid_node_[i]) = values[i];
}

namespace {

std::int64_t bytes_of_table(std::int64_t nodes, std::int64_t entries, std::int64_t dimension) {
  return nodes * std::int64_t{sizeof(std::int64_t)} + (nodes + 1) * std::int64_t{sizeof(std::int32_t)} +
         entries * (std::int64_t{sizeof(std::int32_t) + sizeof(std::uint8_t)} +
                    2 * dimension * std::int64_t{sizeof(double)});
}

} // namespace

std::int64_t LinkTable::bytes_for(const Specimen& body) {
  return bytes_of_table(body.n_matter_nodes(), 2 * body.n_matter_links(), body.grid.dimension());
}

Violations count_violations(const LinkTable& table, const Displacement& displacement, double tolerance) {
  Violations found;
  std::vector<List<double>> u;
  for (int b = 0; b < table.dimension(); ++b)
    u.push_back(table.gather(displacement, b));
  for (std::int32_t node = 0; node < table.n_nodes(); ++node)
    for (auto e = static_cast<std::size_t>(table.first()[node]);
         e < static_cast<std::size_t>(table.first()[static_cast<std::size_t>(node) + 1]); ++e) {
      if (table.direction()[e] % 2 == 0) // every link once, from its near end
        continue;
      double excess = 0;
      for (int b = 0; b < table.dimension(); ++b) {
        const List<double>& v = u[b];
        const double difference = v[node] - v[table.neighbour()[e]];
        excess = std::max({excess, table.below(b)[e] - difference, difference - table.above(b)[e]});
      }
      found.links += excess > tolerance ? 1 : 0;
      found.worst = std::max(found.worst, excess);
    }
  return found;
}

} // namespace maille::deform
