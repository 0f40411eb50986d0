#include "maille/materials/damage.hpp"

#include <algorithm>

namespace maille {

NeighbourLimits limits_before_failure(const Damage& damage) {
  NeighbourLimits limits;
  limits.stretch = damage.stretch;
  for (std::size_t a = 0; a < 3; ++a) {
    const double across = std::min(damage.stretch[(a + 1) % 3], damage.stretch[(a + 2) % 3]);
    limits.compress[a] = damage.compress ? (*damage.compress)[a] : 1 / (across * across);
    for (std::size_t b = 0; b < 3; ++b) {
      const double most = std::min(damage.stretch[a], damage.stretch[b]);
      if (a != b)
        limits.shear[a][b] = damage.shear ? (*damage.shear)[a][b] : most - 1 / most;
    }
  }
  return limits;
}

} // namespace maille
