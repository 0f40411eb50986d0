

#include "feasible/bounds/bound_source.hpp"

#include <algorithm>

namespace maille::deform {

void DijkstraBounds::bounds_at(Side side, int component, std::span<const PathEnd> ends,
                               std::span<const std::int64_t> nodes, std::span<double> values) {
  const std::vector<double> all =
      side == Side::greatest
          ? upper_envelope(scene_, limits_, component, ends)
          : lower_envelope(scene_, limits_, component, std::vector<PathEnd>(ends.begin(), ends.end()));
  std::ranges::transform(nodes, values.begin(),
                         [&](std::int64_t node) { return all[static_cast<std::size_t>(node)]; });
}

std::vector<double> upper_envelope(const Scene& scene, const LinkLimits& limits, int component,
                                   std::span<const PathEnd> ends) {
  return shortest_paths(scene, limits, component, ends, PathDirection::from_ends);
}

std::vector<double> lower_envelope(const Scene& scene, const LinkLimits& limits, int component,
                                   std::vector<PathEnd> ends) {
  // max(p - d) = -min(-p + d)
  for (PathEnd& end : ends)
    end.potential = -end.potential;
  std::vector<double> lowest = shortest_paths(scene, limits, component, ends, PathDirection::to_ends);
  for (double& value : lowest)
    value = 0.0 - value; // and not -value: no negative zeros
  return lowest;
}

} // namespace maille::deform
