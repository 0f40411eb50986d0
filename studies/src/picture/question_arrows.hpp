#pragma once
/// Positions and directions of arrows in a question picture; colours of boundary conditions.

#include "picture/layout.hpp"

#include <vector>

namespace maille::studies {

inline constexpr Vec3 held_colour{0.10, 0.12, 0.16}, moved_colour{0.82, 0.10, 0.12},
    loaded_colour{0.45, 0.15, 0.65}, sprung_colour{0.60, 0.40, 0.16}, fibre_colour{0.25, 0.27, 0.32};

/// Centre of a load's or spring's face.
template<class Face>
Vec3 middle_of_face(const Specimen& body, const Face& face) {
  Vec3 middle = body.position(body.grid.cell_at(face.cell));
  for (int a = 0; a < body.grid.dimension(); ++a)
    middle[a] += (static_cast<int>(a) == face.axis ? (face.upper ? 1 : 0) : 0.5) * body.grid.spacing()[a];
  return middle;
}

/// An arrow in the picture plane, from or to a point of the body [m].
struct Arrow {
  Vec3 from{}, to{}; ///< object's frame [m]
  Vec3 colour{};
};
/// Arrows of moves, drives (at their furthest), tractions and gravity, all of that length [m].
std::vector<Arrow> arrows_of(const Scene& scene, double length);

} // namespace maille::studies
