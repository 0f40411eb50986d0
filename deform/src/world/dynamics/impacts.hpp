#pragma once
/// Impulses between touching rigid objects.

#include "world/dynamics/moving_object.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace maille::deform {

/// A point where two objects touch.
struct ImpactPoint {
  int object = 0, other = -1; ///< -1: the border of the world
  std::int32_t node = 0;      ///< of the skin whose nodes touch faces of the other
  Eigen::Vector3d at, normal; ///< unit vector from the other to the object
  double gap = 0;             ///< [m]
  double lead = 0;            ///< required opening speed, at least [m/s]
  double impulse = 0;         ///< on the object along the normal, so far [N s]
};

/// The points, in order, that can carry any load of all points: for a face that lies on another, its corners.
/// @param points sorted by pairs
std::vector<ImpactPoint> carriers_of(std::span<const ImpactPoint> points);

/// Changes speeds so that no touching objects approach each other, pair by pair, the fastest approach first:
/// an impact passes through a row of balls as in Newton's cradle.
///
/// All points of a pair are solved at once (contact_forces); each separates at `restitution` times its
/// approach speed. If that would give the pair energy, its points stay in contact. Momentum is conserved
/// within rounding.
///
/// @param points sorted by pairs @param poses,moving by object
/// @param restitution 0 to 1
/// @return the fastest remaining approach; above rounding only if objects without mass press others between
///         them [m/s]
double resolve_impacts(std::span<ImpactPoint> points, std::span<const Pose> poses,
                       std::span<MovingObject> moving, double restitution);

} // namespace maille::deform
