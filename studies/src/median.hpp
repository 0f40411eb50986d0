#pragma once
/// The median of measured values.

#include <algorithm>
#include <vector>

namespace maille::studies {

/// Median; for an even number the upper middle value, so that it is a measured one; 0 without values. O(n).
inline double upper_median(std::vector<double> values) {
  if (values.empty())
    return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

} // namespace maille::studies
