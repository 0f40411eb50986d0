#include "feasible/bounds/bound_source.hpp"

#include "feasible/bounds/envelope.hpp"

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

} // namespace maille::deform
