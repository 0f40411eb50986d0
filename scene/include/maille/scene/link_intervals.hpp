#pragma once
/// What limits grant: intervals for the difference of displacement of two linked nodes.

#include <algorithm>
#include <array>
#include <cstddef>

namespace maille {

/// low[i] <= u_next - u_node <= high[i], low <= 0 <= high: of one link per component, or of one component per
/// link axis. Metres, or whole quanta. Where there are many of the kind, `Number` is an array of them or a
/// pointer into one, by node or by kind of cell.
template<class Number>
struct LinkIntervals {
  std::array<Number, 3> low{}, high{};

  /// To what both grant, which the rest state always is.
  void narrow_to(const LinkIntervals& other) {
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] = std::max(low[i], other.low[i]);
      high[i] = std::min(high[i], other.high[i]);
    }
  }
};

} // namespace maille
