#pragma once
/// What lies beyond a plane through the body at rest, on the side that its normal points to.

#include "maille/scene/measure/measure.hpp"

#include <span>

namespace maille {

/// Part of the box [0, sizes] in which normal . x > offset: the volume of a simplex cut by the corners of a
/// box, by inclusion and exclusion. Axes along which normal . x changes by less than 1e-5 of the most are
/// taken at their middle, within 1e-10, rounding up to 1e-6 just above that aside.
double share_beyond(std::span<const double> sizes, std::span<const double> normal, double offset);

class BeyondPlane {
public:
  BeyondPlane(const Specimen& specimen, const SectionPlane& plane);

  /// Distance of a node from the plane, > 0 beyond [m]. @return 0 where it is rounding beside a spacing
  double distance(std::int64_t node) const;
  /// Part of a cell's volume, or of the area of one of its faces.
  double share(std::int64_t cell) const;
  double share(const FaceLoad& face) const;

private:
  double share_of(std::int64_t cell, const FaceLoad* face) const;

  const Specimen& body_;
  SectionPlane plane_;
  double rounding_; ///< [m]
};

/// Sum of what acts on the body beyond the plane from outside: reactions, tractions and weight, object's
/// frame [N]. That part is in balance, so it is the force that it exerts on the rest, across the plane.
/// @pre the answer has reactions
Vec3 force_across(const Scene& scene, const SectionPlane& plane, const Answer& answer);

} // namespace maille
