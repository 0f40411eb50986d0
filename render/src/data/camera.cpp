#include "maille/render/camera.hpp"
#include "maille/base/vectors.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace maille::render {

namespace {

double radians(double degrees) {
  return degrees * std::numbers::pi / 180;
}

/// `v` rotated about a unit vector: Rodrigues' formula.
Vec3 turned_about(const Vec3& v, const Vec3& axis, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return plus(plus(times(c, v), times(s, cross(axis, v))), times((1 - c) * dot(axis, v), axis));
}

} // namespace

std::array<Vec3, 3> Camera::axes() const {
  const Vec3 ahead = unit(minus(focal_point, position));
  const Vec3 right = unit(cross(ahead, view_up));
  return {right, cross(right, ahead), ahead};
}

double Camera::half_height() const {
  return parallel ? parallel_scale : std::tan(0.5 * radians(view_angle));
}

Ray Camera::ray(int width, int height, double x, double y) const {
  const auto [right, up, ahead] = axes();
  const double half = 0.5 * height;
  const double across = (x + 0.5 - 0.5 * width) / half, upwards = (half - y - 0.5) / half;
  const double reach = half_height();
  const Vec3 aside = plus(times(reach * across, right), times(reach * upwards, up));
  if (parallel)
    return {plus(position, aside), ahead};
  return {position, unit(plus(ahead, aside))};
}

Vec3 Camera::project(int width, int height, const Vec3& point) const {
  const auto [right, up, ahead] = axes();
  const Vec3 from_eye = minus(point, position);
  const double depth = dot(from_eye, ahead);
  const double reach = parallel ? half_height() : depth * half_height();
  const double half = 0.5 * height;
  return {0.5 * width - 0.5 + half * dot(from_eye, right) / reach,
          half - 0.5 - half * dot(from_eye, up) / reach, depth};
}

Camera Camera::turned(double azimuth, double elevation) const {
  Camera camera = *this;
  const Vec3 vertical = unit(view_up);
  Vec3 offset = turned_about(minus(position, focal_point), vertical, radians(azimuth));
  Vec3 up = turned_about(view_up, vertical, radians(azimuth));
  const Vec3 right = unit(cross(times(-1, offset), up));
  camera.position = plus(focal_point, turned_about(offset, right, -radians(elevation)));
  camera.view_up = turned_about(up, right, -radians(elevation));
  return camera;
}

Camera Camera::zoomed(double factor) const {
  Camera camera = *this;
  camera.position = plus(focal_point, times(1 / factor, minus(position, focal_point)));
  camera.parallel_scale = parallel_scale / factor;
  return camera;
}

Camera seeing(const Vec3& low, const Vec3& high, const Vec3& direction, const Vec3& view_up, double aspect,
              bool parallel) {
  Camera camera;
  camera.parallel = parallel;
  camera.focal_point = times(0.5, plus(low, high));
  camera.view_up = view_up;
  const double radius = 0.5 * length(minus(high, low)) / std::min(1.0, aspect);
  camera.parallel_scale = radius;
  const double distance = radius / std::sin(0.5 * radians(camera.view_angle));
  camera.position = minus(camera.focal_point, times(distance, unit(direction)));
  return camera;
}

} // namespace maille::render
