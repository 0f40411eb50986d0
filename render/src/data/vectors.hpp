#pragma once
/// Arithmetic of points and directions in double precision. Private to render.

#include "maille/base/grid.hpp"

#include <array>
#include <cmath>

namespace maille::render {

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
inline double length(const Vec3& a) {
  return std::sqrt(dot(a, a));
}
inline Vec3 unit(const Vec3& a) {
  return times(1 / length(a), a);
}
using Rows = std::array<Vec3, 3>;
inline Vec3 times(const Rows& m, const Vec3& a) {
  return {dot(m[0], a), dot(m[1], a), dot(m[2], a)};
}
inline Vec3 transposed_times(const Rows& m, const Vec3& a) {
  return {m[0][0] * a[0] + m[1][0] * a[1] + m[2][0] * a[2], m[0][1] * a[0] + m[1][1] * a[1] + m[2][1] * a[2],
          m[0][2] * a[0] + m[1][2] * a[1] + m[2][2] * a[2]};
}

} // namespace maille::render
