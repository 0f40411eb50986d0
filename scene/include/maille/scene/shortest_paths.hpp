#pragma once
/// Shortest paths over the links of a body: what limits add up to between two nodes.

#include "maille/scene/link_limits.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace maille {

/// A node from which (or to which) paths are measured, with a length to start from.
struct PathEnd {
  std::int64_t node = 0;
  double potential = 0; ///< any finite value [m]
};

/// Which end of a path the given nodes are. The step from a node to its next along an axis costs the link's
/// `high`, the step back costs `-low`, so the two differ where stretch and compression do.
enum class PathDirection { from_ends, to_ends };

/// For every node i of the grid, min over the ends e of potential_e + d(e, i) (or d(i, e) with to_ends), d
/// being the shortest path for one displacement component [m]; +infinity where no path leads and at grid
/// points that are no nodes.
///
/// Dijkstra 1959 with a binary heap: O(links log nodes) time, 8 bytes a grid node. It is the oracle of every
/// faster way. The value at a node is the sum along one path, added up from its end, so it is the same for
/// any order of the ends.
std::vector<double> shortest_paths(const Scene& scene, const LinkLimits& limits, int component,
                                   std::span<const PathEnd> ends, PathDirection direction);

} // namespace maille
