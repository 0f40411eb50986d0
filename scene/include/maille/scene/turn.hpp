#pragma once
/// A move that turns what it moves.

#include "maille/scene/grid.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace maille {

/// Nodes turned about an axis and then shifted, together with the components that are prescribed.
struct Turn {
  Vec3 axis{0, 0, 1}; ///< unit vector; the turn is right-handed about it
  double angle = 0;   ///< [rad], of any size
  Vec3 about{};       ///< a point of the axis [m]
  Vec3 by{};          ///< the shift [m]
  std::array<bool, 3> axes{true, true, true};
  std::vector<std::int64_t> nodes;

  /// Displacement of what rests at x, once that fraction of angle and shift is done [m].
  Vec3 displacement(const Vec3& x, double fraction = 1) const;
};

} // namespace maille
