#pragma once
/// Sizes of displacement fields and of their differences.

#include "maille/scene/answer.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace maille::test {

/// The largest component of any node.
inline double largest(const Displacement& u) {
  double most = 0;
  for (const auto& component : u.component)
    for (const double value : component)
      most = std::max(most, std::abs(value));
  return most;
}

inline double largest_difference(const std::vector<double>& u, const std::vector<double>& v) {
  double most = 0;
  for (std::size_t i = 0; i < u.size(); ++i)
    most = std::max(most, std::abs(u[i] - v[i]));
  return most;
}

/// The largest difference of any component at any node.
inline double largest_difference(const Displacement& u, const Displacement& v) {
  double most = 0;
  for (std::size_t c = 0; c < u.component.size(); ++c)
    most = std::max(most, largest_difference(u.component[c], v.component[c]));
  return most;
}

/// Euclidean, over all components and nodes.
inline double norm(const Displacement& u) {
  double sum = 0;
  for (const auto& component : u.component)
    for (const double value : component)
      sum += value * value;
  return std::sqrt(sum);
}

/// Euclidean, of `found` from `truth`, over the size of `truth`.
inline double relative_difference(const Displacement& found, const Displacement& truth) {
  double difference = 0, size = 0;
  for (std::size_t c = 0; c < truth.component.size(); ++c)
    for (std::size_t i = 0; i < truth.component[c].size(); ++i) {
      difference += std::pow(found.component[c][i] - truth.component[c][i], 2);
      size += std::pow(truth.component[c][i], 2);
    }
  return std::sqrt(difference / size);
}

} // namespace maille::test
