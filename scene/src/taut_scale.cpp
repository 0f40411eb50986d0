#include "taut_scale.hpp"

#include "maille/scene/frame.hpp"
#include "maille/scene/shortest_paths.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace maille {

namespace {

/// The search for one component.
class ComponentScale {
public:
  ComponentScale(const Scene& scene, const LinkLimits& unit, int component,
                 const std::vector<Prescribed>& prescribed)
      : scene_(scene), unit_(unit), component_(component) {
    for (const Prescribed& p : prescribed)
      if (p.component == component)
        ends_.push_back({p.node, p.value});
  }

  double find() const {
    if (ends_.empty())
      return 0;
    const PathEnd& lowest = *std::ranges::min_element(ends_, {}, &PathEnd::potential);
    double found = largest_ratio_at(lowest);
    // Below any ratio that there can be, where the lowest is joined to none that differs.
    double scale = found > 0 ? found : smallest_difference() / longest_path();
    while (scale > 0) {
      const std::optional<PathEnd> end = farthest_apart(scale);
      const double ratio = end ? largest_ratio_at(*end) : 0;
      if (!(ratio > scale)) // none is apart, or by rounding alone
        break;
      found = scale = ratio;
    }
    return found;
  }

private:
  /// Over the other ends: the largest |difference of values| / length of the path.
  double largest_ratio_at(const PathEnd& from) const {
    const PathEnd start{from.node, 0};
    const std::vector<double> length =
        shortest_paths(scene_, unit_, component_, {&start, 1}, PathDirection::from_ends);
    double ratio = 0;
    for (const PathEnd& end : ends_)
      if (end.potential != from.potential)
        ratio = std::max(ratio, std::abs(end.potential - from.potential) /
                                    length[static_cast<std::size_t>(end.node)]);
    return ratio;
  }

  /// The end whose value lies highest above what paths from the others let it have at that scale.
  std::optional<PathEnd> farthest_apart(double scale) const {
    std::vector<PathEnd> scaled = ends_;
    for (PathEnd& end : scaled)
      end.potential /= scale;
    const std::vector<double> reach =
        shortest_paths(scene_, unit_, component_, scaled, PathDirection::from_ends);
    std::optional<PathEnd> farthest;
    double most = 0;
    for (std::size_t i = 0; i < ends_.size(); ++i) {
      const double above = scaled[i].potential - reach[static_cast<std::size_t>(ends_[i].node)];
      if (above > most) {
        most = above;
        farthest = ends_[i];
      }
    }
    return farthest;
  }

  /// Between neighbours among the sorted values; 0 where all are the same.
  double smallest_difference() const {
    std::vector<double> values;
    for (const PathEnd& end : ends_)
      values.push_back(end.potential);
    std::ranges::sort(values);
    double smallest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < values.size(); ++i)
      if (values[i] > values[i - 1])
        smallest = std::min(smallest, values[i] - values[i - 1]);
    return std::isfinite(smallest) ? smallest : 0;
  }

  /// No shortest path is longer.
  double longest_path() const {
    const Grid& grid = scene_.specimen.grid;
    double longest_link = 0;
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
      for (int axis = 0; axis < grid.dimension(); ++axis) {
        const Index3 at = grid.node_at(node);
        if (at[static_cast<std::size_t>(axis)] + 1 >= grid.nodes()[static_cast<std::size_t>(axis)])
          continue;
        if (const LinkBounds link = unit_.bounds(at, axis); link.exists)
          longest_link = std::max(longest_link, link.high[static_cast<std::size_t>(component_)]);
      }
    return longest_link * static_cast<double>(grid.n_nodes());
  }

  const Scene& scene_;
  const LinkLimits& unit_;
  int component_;
  std::vector<PathEnd> ends_; ///< with the prescribed values
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
