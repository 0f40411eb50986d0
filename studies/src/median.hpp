#pragma once
/// The median of measured values.

#include <algorithm>
#include <vector>

namespace maille::studies {

/// Of an even number the upper of the two in the middle, so that it is one that was measured; 0 of none.
/// O(n).
inline double upper_median(std::vector<double> values) {
  if (values.empty())
    return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

} // namespace maille::studies
