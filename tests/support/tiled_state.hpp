#pragma once
/// What a tiled body holds, as tests compare it.

#include "feasible/wavefront/wavefront.hpp"
#include "maille/scene/answer.hpp"
#include "maille/scene/scene.hpp"

#include <algorithm>

namespace maille::test {

inline Displacement state_of(const Scene& scene, const deform::TiledBody& body) {
  Displacement u(scene.specimen.grid);
  body.copy_to(u);
  return u;
}

/// The coarsest step among the components [m].
inline double largest_quantum(const Scene& scene, const deform::TiledBody& body) {
  double q = 0;
  for (int b = 0; b < scene.dimension(); ++b)
    q = std::max(q, body.quantum(b));
  return q;
}

} // namespace maille::test
