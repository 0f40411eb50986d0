#pragma once
/// Arithmetic of points and directions in double precision, and sizes of a grid's cells.

#include "maille/base/grid.hpp"

#include <array>
#include <cmath>

namespace maille {

inline Vec3 plus(const Vec3& a, const Vec3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline Vec3 minus(const Vec3& a, const Vec3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Vec3 times(double s, const Vec3& a) {
  return {s * a[0], s * a[1], s * a[2]};
}
inline double dot(const Vec3& a, const Vec3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
/// Without overflow, which costs some 10 ns.
inline double norm(const Vec3& a) {
  return std::hypot(a[0], a[1], a[2]);
}
inline double distance(const Vec3& a, const Vec3& b) {
  return norm(minus(a, b));
}
/// The quickest: for rays. @pre squares do not overflow
inline double length(const Vec3& a) {
  return std::sqrt(dot(a, a));
}
inline Vec3 unit(const Vec3& a) {
  return times(1 / length(a), a);
}
using Rows = std::array<Vec3, 3>;
inline double determinant(const Rows& m) {
  return dot(m[0], cross(m[1], m[2]));
}
inline Vec3 times(const Rows& m, const Vec3& a) {
  return {dot(m[0], a), dot(m[1], a), dot(m[2], a)};
}
inline Vec3 transposed_times(const Rows& m, const Vec3& a) {
  return {m[0][0] * a[0] + m[1][0] * a[1] + m[2][0] * a[2], m[0][1] * a[0] + m[1][1] * a[1] + m[2][1] * a[2],
          m[0][2] * a[0] + m[1][2] * a[1] + m[2][2] * a[2]};
}

/// Area of a cell's face across an axis [m^2]; of 1 m of thickness in 2D, 1 in 1D.
inline double face_area(const Grid& grid, int axis) {
  double area = 1;
  for (int a = 0; a < grid.dimension(); ++a)
    area *= a == axis ? 1 : grid.spacing()[a];
  return area;
}
/// Likewise of a cell [m^3].
inline double cell_volume(const Grid& grid) {
  return face_area(grid, -1);
}

} // namespace maille
