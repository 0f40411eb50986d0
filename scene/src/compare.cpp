#include "maille/scene/compare.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace maille {

namespace {

/// 0 / 0 is no error at all; anything else over 0 is without measure.
double ratio(double part, double whole) {
  if (part == 0)
    return 0;
  return whole > 0 ? part / whole : std::numeric_limits<double>::infinity();
}

} // namespace

ErrorNorms compare(const Scene& scene, const Displacement& answer, const Displacement& reference) {
  const Grid& grid = scene.specimen.grid;
  std::vector<bool> counted(static_cast<std::size_t>(grid.n_nodes()), true);
  for (const Prescribed& p : scene.prescribed)
    counted[static_cast<std::size_t>(p.node)] = false;

  double difference_sq = 0, reference_sq = 0, largest_difference_sq = 0, largest_reference_sq = 0;
  std::int64_t n = 0;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    if (!counted[static_cast<std::size_t>(node)] || !scene.specimen.is_node(grid.node_at(node)))
      continue;
    double d_sq = 0, r_sq = 0;
    for (int b = 0; b < grid.dimension(); ++b) {
      const double d = answer(b, node) - reference(b, node);
      d_sq += d * d;
      r_sq += reference(b, node) * reference(b, node);
    }
    difference_sq += d_sq;
    reference_sq += r_sq;
    largest_difference_sq = std::max(largest_difference_sq, d_sq);
    largest_reference_sq = std::max(largest_reference_sq, r_sq);
    ++n;
  }
  if (n == 0)
    return {};
  return {.relative_l2 = ratio(std::sqrt(difference_sq), std::sqrt(reference_sq)),
          .relative_max = ratio(std::sqrt(largest_difference_sq), std::sqrt(largest_reference_sq)),
          .rms = std::sqrt(difference_sq / static_cast<double>(n))};
}

} // namespace maille
