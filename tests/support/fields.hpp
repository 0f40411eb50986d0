#pragma once
/// Norms of displacement fields and of their differences.

#include "maille/scene/answer.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

namespace maille::test {

/// Largest component of all nodes.
inline double largest(const Displacement& u) {
  double most = 0;
  for (const double value : u.values())
    most = std::max(most, std::abs(value));
  return most;
}

/// Largest difference of values; NaN if one of them is NaN.
inline double largest_difference(std::span<const double> u, std::span<const double> v) {
  double most = 0;
  for (std::size_t i = 0; i < u.size() && !std::isnan(most); ++i)
    if (const double difference = std::abs(u[i] - v[i]); !(difference <= most))
      most = difference;
  return most;
}

/// The largest difference of any component at any node.
inline double largest_difference(const Displacement& u, const Displacement& v) {
  return largest_difference(u.values(), v.values());
}

/// Scalar product over all components and nodes.
inline double product(const Displacement& u, const Displacement& v) {
  return std::inner_product(u.values().begin(), u.values().end(), v.values().begin(), 0.0);
}

/// Euclidean norm over all components and nodes.
inline double norm(const Displacement& u) {
  return std::sqrt(product(u, u));
}

/// Euclidean distance of `found` from `truth`, relative to the norm of `truth`.
inline double relative_difference(const Displacement& found, const Displacement& truth) {
  double difference = 0, size = 0;
  for (std::size_t i = 0; i < truth.values().size(); ++i) {
    difference += std::pow(found.values()[i] - truth.values()[i], 2);
    size += std::pow(truth.values()[i], 2);
  }
  return std::sqrt(difference / size);
}

} // namespace maille::test
