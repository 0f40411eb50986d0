#pragma once
/// Impulses between rigid objects that touch.

#include "world/dynamics/moving_object.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace maille::deform {

/// A point where two objects touch.
struct ImpactPoint {
  int object = 0, other = -1; ///< -1: the border of the world
  std::int32_t node = 0;      ///< of the skin that meets the other's faces
  Eigen::Vector3d at, normal; ///< of length 1, from the other to the object
  double gap = 0;             ///< [m]
  double lead = 0;            ///< speed at which it is to open at least [m/s]
  double impulse = 0;         ///< on the object along the normal, so far [N s]
};

/// Those of the points, in order, that carry whatever all of them could: of a face that lies on another its
/// corners. @param points by their pairs
std::vector<ImpactPoint> carriers_of(std::span<const ImpactPoint> points);

/// Changes speeds so that nothing that touches comes nearer, pair of objects after pair, the one that
/// approaches fastest first: so a blow goes through a row of balls as through Newton's cradle.
///
/// Within a pair all its points take part at once (contact_forces), each leaving as fast as `restitution`
/// times the speed it came with; where that would give the pair energy, its points stay together.
/// Momentum is kept to rounding: what one object gets the other loses.
///
/// @param points by their pairs @param poses,moving one an object
/// @param restitution 0 to 1
/// @return the fastest approach that is left, more than rounding only where objects without mass press others
///         between them [m/s]
double resolve_impacts(std::span<ImpactPoint> points, std::span<const Pose> poses,
                       std::span<MovingObject> moving, double restitution);

} // namespace maille::deform
