#pragma once
/// Sizes of displacement fields and of their differences.

#include "maille/scene/answer.hpp"

#include <algorithm>
#include <cmath>

namespace maille::test {

/// The largest component of any node.
inline double largest(const Displacement& u) {
  double most = 0;
  for (const auto& component : u.component)
    for (const double value : component)
      most = std::max(most, std::abs(value));
  return most;
}

/// The largest difference of any component at any node.
inline double largest_difference(const Displacement& u, const Displacement& v) {
  double most = 0;
  for (std::size_t c = 0; c < u.component.size(); ++c)
    for (std::size_t n = 0; n < u.component[c].size(); ++n)
      most = std::max(most, std::abs(u.component[c][n] - v.component[c][n]));
  return most;
}

} // namespace maille::test
