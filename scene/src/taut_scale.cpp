#include "taut_scale.hpp"

#include "maille/scene/frame.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace maille {

namespace {

/// Limits each of n values, `stride` apart, to its neighbours plus a step.
void scan(double* values, std::int64_t n, std::int64_t stride, double step) {
  for (std::int64_t i = 1; i < n; ++i)
    values[i * stride] = std::min(values[i * stride], values[(i - 1) * stride] + step);
  for (std::int64_t i = n - 1; i-- > 0;)
    values[i * stride] = std::min(values[i * stride], values[(i + 1) * stride] + step);
}

/// The same for rows of `width` adjacent values, which compilers vectorise.
void scan_rows(double* values, std::int64_t n, std::int64_t width, double step) {
  const auto lower = [&](std::int64_t row, std::int64_t other) {
    double* const here = values + row * width;
    const double* const there = values + other * width;
    for (std::int64_t i = 0; i < width; ++i) {
      const double reached = there[i] + step;
      here[i] = here[i] < reached ? here[i] : reached;
    }
  };
  for (std::int64_t row = 1; row < n; ++row)
    lower(row, row - 1);
  for (std::int64_t row = n - 1; row-- > 0;)
    lower(row, row + 1);
}

/// shortest_paths() on a box with equal links along each axis and in both directions: a path follows one axis
/// after the other.
/// @param steps  their lengths by axis
List<double> paths_on_a_box(const Grid& grid, const Vec3& steps, std::span<const PathEnd> ends) {
  List<double> length(static_cast<std::size_t>(grid.n_nodes()), std::numeric_limits<double>::infinity());
  for (const PathEnd& end : ends)
    length[end.node] = std::min(length[end.node], end.potential);
  const std::int64_t nx = grid.nodes()[0];
  for (std::int64_t first = 0; first < grid.n_nodes(); first += nx)
    scan(length.data() + first, nx, 1, steps[0]);
  for (int axis = 1; axis < grid.dimension(); ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const std::int64_t n = grid.nodes()[a], width = grid.stride(axis);
    for (std::int64_t first = 0; first < grid.n_nodes(); first += n * width)
      scan_rows(length.data() + first, n, width, steps[a]);
  }
  return length;
}

/// The search for one component.
class ComponentScale {
public:
  ComponentScale(const Scene& scene, const LinkLimits& unit, int component,
                 const std::vector<Prescribed>& prescribed)
      : scene_(scene), unit_(unit), component_(component),
        is_box_(unit.is_homogeneous() && scene.specimen.n_matter_cells() == scene.specimen.grid.n_cells()) {
    for (const Prescribed& p : prescribed)
      if (p.component == component)
        ends_.push_back({p.node, p.value});
    for (const PathEnd& end : ends_)
      values_.push_back(end.potential);
    std::ranges::sort(values_);
    values_.erase(std::unique(values_.begin(), values_.end()), values_.end());
  }

  double find() const {
    if (values_.size() < 2)
      return 0;
    double found = largest_ratio_from_lowest();
    if (values_.size() == 2)
      return found;
    // If no lowest node is connected to a different value, starts below any possible ratio.
    double scale = found > 0 ? found : smallest_difference() / longest_path();
    while (scale > 0) {
      const std::optional<PathEnd> end = farthest_apart(scale);
      const double ratio = end ? largest_ratio_at(*end) : 0;
      if (!(ratio > scale)) // no violation beyond rounding
        break;
      found = scale = ratio;
    }
    return found;
  }

private:
  List<double> paths_from(std::span<const PathEnd> ends) const {
    if (!is_box_)
      return shortest_paths(scene_, unit_, component_, ends, PathDirection::from_ends);
    Vec3 steps{};
    for (std::size_t a = 0; a < 3; ++a)
      steps[a] = unit_.kinds().front()[a].high[component_];
    return paths_on_a_box(scene_.specimen.grid, steps, ends);
  }

  /// Largest ratio of value difference and path length from the lowest ends to the others. With two values it
  /// is the largest ratio.
  double largest_ratio_from_lowest() const {
    std::vector<PathEnd> lowest;
    for (const PathEnd& end : ends_)
      if (end.potential == values_.front())
        lowest.push_back({end.node, 0});
    return largest_ratio(values_.front(), paths_from(lowest));
  }
  /// Largest |difference of values| / path length from one end to the others.
  double largest_ratio_at(const PathEnd& from) const {
    const PathEnd start{from.node, 0};
    return largest_ratio(from.potential, paths_from({&start, 1}));
  }
  double largest_ratio(double value, const List<double>& length) const {
    double ratio = 0;
    for (const PathEnd& end : ends_)
      if (end.potential != value)
        ratio = std::max(ratio, std::abs(end.potential - value) / length[end.node]);
    return ratio;
  }

  /// The end that most exceeds the bound by paths from the others at that scale.
  std::optional<PathEnd> farthest_apart(double scale) const {
    std::vector<PathEnd> scaled = ends_;
    for (PathEnd& end : scaled)
      end.potential /= scale;
    const List<double> reach = paths_from(scaled);
    std::optional<PathEnd> farthest;
    double most = 0;
    for (std::size_t i = 0; i < ends_.size(); ++i) {
      const double above = scaled[i].potential - reach[ends_[i].node];
      if (above > most) {
        most = above;
        farthest = ends_[i];
      }
    }
    return farthest;
  }

  double smallest_difference() const {
    double smallest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < values_.size(); ++i)
      smallest = std::min(smallest, values_[i] - values_[i - 1]);
    return smallest;
  }

  /// Upper bound of the lengths of shortest paths.
  double longest_path() const {
    double longest_link = 0;
    for (const LinkLimits::OfCell& cell : unit_.kinds())
      for (int axis = 0; axis < scene_.dimension(); ++axis)
        longest_link = std::max(longest_link, cell[axis].high[component_]);
    return longest_link * static_cast<double>(scene_.specimen.grid.n_nodes());
  }

  const Scene& scene_;
  const LinkLimits& unit_;
  int component_;
  bool is_box_;
  std::vector<PathEnd> ends_;  ///< with the prescribed values
  std::vector<double> values_; ///< the different ones, sorted
};

} // namespace

double taut_scale(const Scene& scene, const LinkLimits& unit) {
  const std::vector<Prescribed> prescribed = prescribed_in_object(scene, object_frame(scene));
  double scale = 0;
  for (int component = 0; component < scene.dimension(); ++component)
    scale = std::max(scale, ComponentScale(scene, unit, component, prescribed).find());
  return scale;
}

} // namespace maille
