#include "elastic/links/interval_field.hpp"

#include "feasible/bounds/clipping.hpp"
#include "lattice/field_memory.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>

namespace maille::deform {

IntervalField::IntervalField(const Scene& scene, const LinkLimits& limits, int component)
    : dimension_(scene.dimension()), nodes_(scene.specimen.grid.nodes()) {
  const auto b = static_cast<std::size_t>(component);
  const Grid& grid = scene.specimen.grid;
  const bool is_same =
      limits.is_homogeneous() && scene.specimen.n_matter_cells() == scene.specimen.grid.n_cells();
  for (int axis = 0; axis < dimension_; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    if (is_same) {
      intervals_.low[a] = {limits.kinds().front()[a].low[b]};
      intervals_.high[a] = {limits.kinds().front()[a].high[b]};
      continue;
    }
    intervals_.low[a].assign(grid.n_nodes(), -std::numeric_limits<double>::infinity());
    intervals_.high[a].assign(grid.n_nodes(), std::numeric_limits<double>::infinity());
  }
  if (is_same)
    return;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    if (!scene.specimen.is_matter(cell))
      continue;
    const LinkLimits::OfCell& of_cell = limits.kinds()[limits.kind_of(cell)];
    for (int axis = 0; axis < dimension_; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      for (int corner = 0; corner < grid.corners_per_cell(); ++corner) {
        if (corner >> axis & 1)
          continue;
        const auto node = static_cast<std::size_t>(grid.corner(grid.cell_at(cell), corner));
        intervals_.low[a][node] = std::max(intervals_.low[a][node], of_cell[a].low[b]);
        intervals_.high[a][node] = std::min(intervals_.high[a][node], of_cell[a].high[b]);
      }
    }
  }
}

LinkRow IntervalField::row(int axis, const Index3& at, const double* u) const {
  const auto a = static_cast<std::size_t>(axis);
  if (axis > 0 && at[a] + 1 >= nodes_[a])
    return {};
  const std::int64_t in_plane = std::int64_t{1} * nodes_[0] * nodes_[1];
  const std::int64_t first = std::int64_t{1} * nodes_[0] * at[1] + in_plane * at[2];
  LinkRow links;
  links.n = axis == 0 ? nodes_[0] - 1 : nodes_[0];
  links.here = u + first;
  links.next = links.here + (axis == 0 ? 1 : axis == 1 ? nodes_[0] : in_plane);
  links.is_same = is_same_everywhere();
  links.low = intervals_.low[a].data() + (links.is_same ? 0 : first);
  links.high = intervals_.high[a].data() + (links.is_same ? 0 : first);
  return links;
}

double IntervalField::excess_in_plane(int z, const double* u) const {
  // In 2D planes are rows.
  const bool is_flat = nodes_[2] == 1;
  const int first_row = is_flat ? z : 0, last_row = is_flat ? z : nodes_[1] - 1, plane = is_flat ? 0 : z;
  double worst = 0;
  for (int y = first_row; y <= last_row; ++y)
    for (int axis = 0; axis < dimension_; ++axis)
      worst = std::max(worst, largest_excess(row(axis, {0, y, plane}, u)));
  return worst;
}

bool IntervalField::is_any_outside_in_row(int axis, const Index3& at, const double* u,
                                          double tolerance) const {
  return is_any_outside(row(axis, at, u), tolerance);
}

std::array<double, 2> range_of(std::span<const double> values) {
  constexpr std::size_t lanes = line_of_floats / 2; // several at a time
  std::array<double, lanes> least{}, most{};
  const auto visit = [&](std::size_t lane, double value) {
    least[lane] = value < least[lane] ? value : least[lane];
    most[lane] = value > most[lane] ? value : most[lane];
  };
  std::size_t i = 0;
  for (; i + lanes <= values.size(); i += lanes)
    for (std::size_t lane = 0; lane < lanes; ++lane)
      visit(lane, values[i + lane]);
  for (; i < values.size(); ++i)
    visit(0, values[i]);
  return {*std::ranges::min_element(least), *std::ranges::max_element(most)};
}

bool cannot_be_reached(const LinkLimits& limits, int component, int dimension, double least, double most) {
  const LinkLimits::OfCell granted = limits.granted_everywhere();
  const auto b = static_cast<std::size_t>(component);
  for (std::size_t a = 0; a < static_cast<std::size_t>(dimension); ++a)
    if (granted[a].low[b] > least - most || granted[a].high[b] < most - least)
      return false;
  return true;
}

bool permit_all_that_is_prescribed(const LinkLimits& limits, const Scene& scene) {
  for (int component = 0; component < scene.dimension(); ++component) {
    double least = std::numeric_limits<double>::infinity(), most = -least;
    for (const Prescribed& p : scene.prescribed)
      if (p.component == component) {
        least = std::min(least, p.value);
        most = std::max(most, p.value);
      }
    if (most > least && !cannot_be_reached(limits, component, scene.dimension(), least, most))
      return false;
  }
  return true;
}

bool breaks_limits(const Scene& scene, const LinkLimits& limits, ThreadTeam& team, int component,
                   std::span<const double> u, double rounding) {
  const auto [least, most] = range_of(u);
  if (cannot_be_reached(limits, component, scene.dimension(), least, most))
    return false;
  const IntervalField ranges(scene, limits, component);
  std::vector<double> excess(ranges.n_planes());
  team.run(ranges.n_planes(), [&](int z, int) { excess[z] = ranges.excess_in_plane(z, u.data()); });
  return std::ranges::max(excess) > rounding;
}

bool breaks_limits(const Scene& scene, const LinkLimits& limits, ThreadTeam& team, const Displacement& u,
                   double part) {
  const auto [least, most] = range_of(u.values());
  const double largest = std::max(-least, most),
               rounding = std::max(part * largest, rounding_tolerance(scene.specimen.grid, largest));
  for (int b = 0; b < scene.dimension(); ++b)
    if (breaks_limits(scene, limits, team, b, u.component(b), rounding))
      return true;
  return false;
}

} // namespace maille::deform
