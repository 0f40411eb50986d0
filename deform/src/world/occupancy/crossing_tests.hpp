#pragma once
/// Which parts of a skin cross.

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cmath>
#include <limits>

namespace maille::deform {

/// In two dimensions; touching counts.
inline bool do_segments_cross(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                              const Eigen::Vector3d& d) {
  const auto side = [](const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& r) {
    return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
  };
  return side(a, b, c) * side(a, b, d) <= 0 && side(c, d, a) * side(c, d, b) <= 0;
}

/// True if a segment crosses a triangle. Source  Moeller and Trumbore 1997.
inline bool does_segment_cross(const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                               const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  constexpr double rounding = 1e-9;
  const Eigen::Vector3d way = to - from, ab = b - a, ac = c - a, across = way.cross(ac);
  const double determinant = ab.dot(across);
  if (std::abs(determinant) < std::numeric_limits<double>::min())
    return false;
  const Eigen::Vector3d off = from - a, turned = off.cross(ab);
  const double u = off.dot(across) / determinant, v = way.dot(turned) / determinant,
               t = ac.dot(turned) / determinant;
  return u >= -rounding && v >= -rounding && u + v <= 1 + rounding && t >= 0 && t <= 1;
}

} // namespace maille::deform
