#pragma once
/// Tiled bodies, and their state in a form that tests compare.

#include "feasible/wavefront/wavefront.hpp"
#include "maille/scene/answer.hpp"
#include "support/bodies/holed_bodies.hpp"

#include <algorithm>

namespace maille::test {

inline Displacement state_of(const Scene& scene, const deform::TiledBody& body) {
  Displacement u(scene.specimen.grid);
  body.copy_to(u);
  return u;
}

/// A random body with holes.
struct HoledTiles {
  explicit HoledTiles(unsigned seed)
      : random(seed), scene(holed_body(random)), limits(scene), body(scene, limits) {}
  HoledTiles(const HoledTiles&) = delete; // limits and body refer to the scene
  HoledTiles& operator=(const HoledTiles&) = delete;

  std::mt19937 random;
  Scene scene;
  LinkLimits limits;
  deform::TiledBody body;
};

/// The coarsest step among the components [m].
inline double largest_quantum(const Scene& scene, const deform::TiledBody& body) {
  double q = 0;
  for (int b = 0; b < scene.dimension(); ++b)
    q = std::max(q, body.quantum(b));
  return q;
}

} // namespace maille::test
