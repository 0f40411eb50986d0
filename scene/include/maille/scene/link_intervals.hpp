#pragma once
/// Limits of links: intervals for the displacement difference of two linked nodes.

#include <algorithm>
#include <array>
#include <cstddef>

namespace maille {

/// low[i] <= u_next - u_node <= high[i], low <= 0 <= high: per component of one link, or per link axis of one
/// component. In metres or whole quanta. For many links, `Number` is an array or a pointer into one, by node
/// or by kind of cell.
template<class Number>
struct LinkIntervals {
  std::array<Number, 3> low{}, high{};

  /// Narrows to the intersection, which always contains the rest state.
  void narrow_to(const LinkIntervals& other) {
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] = std::max(low[i], other.low[i]);
      high[i] = std::min(high[i], other.high[i]);
    }
  }
};

} // namespace maille
