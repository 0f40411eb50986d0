#pragma once
/// The obvious ray caster, in double precision: every sample of every object, all at once, in order.

#include "maille/scene/look.hpp"

#include <array>
#include <functional>
#include <vector>

namespace maille::lab::rivals {

/// Values on a grid in an object's frame, as numbers; rigid, or deformed with a lattice.
struct PlainObject {
  Index3 size{1, 1, 1};
  Vec3 spacing{1, 1, 1}, origin{}; ///< [m]; of the centre of voxel 0
  std::vector<double> values;      ///< x fastest
  std::vector<double> smooth;      ///< those whose central differences are gradients
  double low = 0, high = 1;        ///< range of values that steepness is measured against
  Look look;                       ///< mode composite, maximum or isosurface
  double unit_distance = 0;        ///< of its opacities [m]
  std::array<Vec3, 3> rotation{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}; ///< rows, object -> world
  Vec3 position{};

  Index3 cells{0, 0, 0}; ///< of the lattice; 0: rigid
  Vec3 lattice_origin{}, lattice_spacing{};
  std::vector<Vec3> nodes; ///< where they are, object's frame [m]
};

struct PlainView {
  Vec3 ahead{0, 0, -1}, light{0, 0, 1};     ///< unit vectors in the world; light: towards it
  double step = 0;                          ///< between samples of all objects [m]
  double farthest = 0;                      ///< along rays [m]
  std::vector<std::array<Vec3, 2>> clips{}; ///< a point and the normal of the side that is kept
};

/// The values, filtered twice along each axis by weights of 1/4, 1/2, 1/4, as Maille does for gradients.
std::vector<double> smoothed(const PlainObject& of);

/// What a ray sees: premultiplied colour and opacity.
///
/// A sample's point is carried into an object's frame, of a deformed one by trying every cell that may hold
/// it; values and gradients (central differences of `smooth`, g / (|g| + k), k a 200th of the range over
/// the smallest spacing) are trilinear. Light is ambient + diffuse n.l and mirrored (r.e)^shininess, n facing
/// the eye, both ways where it is seen edge on; where |g| is below 1/4 in proportion flat. Flat is, too, what
/// lies up to a voxel behind a cut (a clip plane, or where the image ends), less and less to the second
/// voxel. Isosurfaces are looked for at every sixteenth of a step and halved.
///
/// Cost  all samples, all cells near the ray
std::array<double, 4> cast_plainly(const std::vector<PlainObject>& objects, const PlainView& view,
                                   const Vec3& origin, const Vec3& direction);

} // namespace maille::lab::rivals
