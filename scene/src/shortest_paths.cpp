#include "maille/scene/link_limits.hpp"

#include <limits>
#include <queue>

namespace maille {

namespace {

using Entry = std::pair<double, std::int64_t>; // distance so far, node

/// Length of the step from a link's near node to its far one (forward) or back.
double step_length(const LinkIntervals<double>& link, std::size_t component, bool forward) {
  return forward ? link.high[component] : -link.low[component];
}

} // namespace

List<double> shortest_paths(const Scene& scene, const LinkLimits& limits, int component,
                            std::span<const PathEnd> ends, PathDirection direction) {
  const Grid& grid = scene.specimen.grid;
  const std::size_t b = component;
  List<double> distance(static_cast<std::size_t>(grid.n_nodes()), std::numeric_limits<double>::infinity());
  std::priority_queue<Entry, List<Entry>, std::greater<>> queue;
  const auto offer = [&](std::int64_t node, double length) {
    double& best = distance[node];
    if (length < best) {
      best = length;
      queue.emplace(length, node);
    }
  };
  for (const PathEnd& end : ends)
    offer(end.node, end.potential);

  // Paths to the ends are paths from them over reversed links.
  const bool reversed = direction == PathDirection::to_ends;
  while (!queue.empty()) {
    const auto [length, node] = queue.top();
    queue.pop();
    if (length > distance[node])
      continue;
    const Index3 at = grid.node_at(node);
    for (int axis = 0; axis < grid.dimension(); ++axis) {
      const std::size_t a = axis;
      if (at[a] + 1 < grid.nodes()[a]) {
        if (const auto link = limits.intervals(at, axis))
          offer(node + grid.stride(axis), length + step_length(*link, b, !reversed));
      }
      if (at[a] > 0) {
        Index3 before = at;
        --before[a];
        if (const auto link = limits.intervals(before, axis))
          offer(node - grid.stride(axis), length + step_length(*link, b, reversed));
      }
    }
  }
  return distance;
}

} // namespace maille
