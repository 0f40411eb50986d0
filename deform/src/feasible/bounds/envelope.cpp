#include "feasible/bounds/envelope.hpp"

namespace maille::deform {

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
