#pragma once
/// The part of the body beyond a plane at rest, on the side of its normal, and the force across the plane.

#include "maille/scene/measure/measure.hpp"

#include <span>

namespace maille {

/// Volume fraction of the box [0, sizes] with normal . x > offset: the volume of a simplex cut by the corners
/// of a box, by inclusion and exclusion. Axes along which normal . x changes by less than 1e-5 of the largest
/// change are evaluated at their middle; accurate to 1e-10, except for rounding up to 1e-6 just above that
/// threshold.
double share_beyond(std::span<const double> sizes, std::span<const double> normal, double offset);

class BeyondPlane {
public:
  BeyondPlane(const Specimen& specimen, const SectionPlane& plane);

  /// Distance of a node from the plane, > 0 beyond [m]. @return 0 if it is only rounding error
  double distance(std::int64_t node) const;
  /// Fraction beyond the plane of a cell's volume, or of the area of one of its faces.
  double share(std::int64_t cell) const;
  double share(const FaceLoad& face) const;

private:
  double share_of(std::int64_t cell, const FaceLoad* face) const;

  const Specimen& body_;
  SectionPlane plane_;
  double rounding_; ///< [m]
};

/// Sum of external forces on the body beyond the plane: reactions, tractions and weight, object's frame [N].
/// That part is in balance, so this is the force that it exerts on the rest across the plane.
/// @pre the answer has reactions
Vec3 force_across(const Scene& scene, const SectionPlane& plane, const Answer& answer);

} // namespace maille
