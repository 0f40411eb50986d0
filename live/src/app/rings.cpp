/// Lines over the picture: rings, axes and marks of rigid objects.

#include "app/app.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace maille::live {

namespace {

constexpr int n_points = 64;
constexpr double reach = 7; // [pixels]
constexpr std::array<std::array<float, 4>, 3> axis_colours{
    {{0.80f, 0.16f, 0.12f, 1}, {0.10f, 0.55f, 0.15f, 1}, {0.10f, 0.25f, 0.80f, 1}}};

} // namespace

Vec3 Sight::in_window(const Eigen::Vector3d& place) const {
  const Vec3 world{place[0], place[1], place[2]};
  if (scene.dimension < 3) {
    const auto at = flat_place(looking, static_cast<double>(width) / std::max(1, height), world);
    return {at[0] * width, at[1] * height, 1};
  }
  return looking.view.camera.project(width, height, world);
}

bool Sight::has_rings(int object) const {
  return object >= 0 && object < static_cast<int>(state.frames.size()) &&
         object < static_cast<int>(scene.objects.size()) && scene.objects[object].kind == ObjectKind::rigid &&
         scene.dimension > 1;
}

std::vector<std::array<float, 2>> Sight::ring(int object, int axis) const {
  const auto [middle, radius] = ball_about(scene, state, object);
  std::vector<std::array<float, 2>> points;
  for (int i = 0; i <= n_points; ++i) {
    const double angle = 2 * std::numbers::pi * i / n_points;
    Eigen::Vector3d place = middle;
    place[(axis + 1) % 3] += 1.15 * radius * std::cos(angle);
    place[(axis + 2) % 3] += 1.15 * radius * std::sin(angle);
    const Vec3 at = in_window(place);
    points.push_back({static_cast<float>(at[0]), static_cast<float>(at[1])});
  }
  return points;
}

std::pair<Eigen::Vector3d, double> ball_about(const WorldScene& scene, const WorldState& state, int object) {
  const std::size_t i = object;
  const Specimen& body = scene.objects[i].scene.specimen;
  double radius = 0;
  for (int a = 0; a < body.grid.dimension(); ++a)
    radius = std::hypot(radius, 0.5 * body.grid.cells()[a] * body.grid.spacing()[a]);
  return {state.frames[i].position + state.frames[i].rotation * deform::middle_of(body), radius};
}

std::vector<OverlayLine> Sight::rings(int object, int grabbed) const {
  std::vector<OverlayLine> lines;
  if (!has_rings(object))
    return lines;
  for (int axis = scene.dimension < 3 ? 2 : 0; axis < 3; ++axis)
    lines.push_back({ring(object, axis), axis_colours[axis], axis == grabbed ? 4.0f : 2.0f});
  return lines;
}

OverlayLine Sight::axis_line(int axis, const Eigen::Vector3d& through, double half_length) const {
  OverlayLine line;
  line.colour = axis_colours[axis];
  for (int i = -n_points / 2; i <= n_points / 2; ++i) { // in segments: some may be behind the eye
    const Eigen::Vector3d place = through + half_length * i / (n_points / 2.0) * Eigen::Vector3d::Unit(axis);
    if (const Vec3 at = in_window(place); at[2] > 0)
      line.points.push_back({static_cast<float>(at[0]), static_cast<float>(at[1])});
  }
  return line;
}

std::vector<OverlayLine> Sight::marks(double text_scale) const {
  constexpr double found_from = 7, mark_radius = 12; // [pixels]
  constexpr std::array<float, 4> colour{0.90f, 0.45f, 0.05f, 1};
  std::vector<OverlayLine> lines;
  for (std::size_t i = 0; i < scene.objects.size() && i < state.frames.size(); ++i) {
    if (scene.objects[i].kind != ObjectKind::rigid)
      continue;
    const auto [middle, radius] = ball_about(scene, state, static_cast<int>(i));
    const Vec3 at = in_window(middle);
    double seen = 0; // its radius in the window, in any view
    for (int a = 0; a < std::min(3, scene.dimension); ++a) {
      const Vec3 side = in_window(middle + radius * Eigen::Vector3d::Unit(a));
      seen = std::max(seen, std::hypot(side[0] - at[0], side[1] - at[1]));
    }
    if (!(at[2] > 0) || !(seen < found_from * text_scale))
      continue;
    OverlayLine& line = lines.emplace_back();
    line.colour = colour;
    for (int point = 0; point <= n_points; ++point) {
      const double angle = 2 * std::numbers::pi * point / n_points, out = mark_radius * text_scale;
      line.points.push_back({static_cast<float>(at[0] + out * std::cos(angle)),
                             static_cast<float>(at[1] + out * std::sin(angle))});
    }
  }
  return lines;
}

int Sight::ring_at(int object, double x, double y) const {
  if (!has_rings(object))
    return -1;
  int nearest = -1;
  double least = reach;
  for (int axis = scene.dimension < 3 ? 2 : 0; axis < 3; ++axis) {
    const auto points = ring(object, axis);
    for (std::size_t i = 1; i < points.size(); ++i) {
      const double dx = points[i][0] - points[i - 1][0], dy = points[i][1] - points[i - 1][1];
      const double length = std::max(1e-9, dx * dx + dy * dy);
      const double t =
          std::clamp(((x - points[i - 1][0]) * dx + (y - points[i - 1][1]) * dy) / length, 0.0, 1.0);
      const double distance = std::hypot(x - points[i - 1][0] - t * dx, y - points[i - 1][1] - t * dy);
      if (distance < least) {
        least = distance;
        nearest = axis;
      }
    }
  }
  return nearest;
}

/// Angle about the ring's centre in the window; reversed for a ring seen from behind.
double Sight::turned(int object, int axis, const std::array<double, 2>& from,
                     const std::array<double, 2>& to) const {
  const auto middle = in_window(ball_about(scene, state, object).first);
  const double before = std::atan2(-(from[1] - middle[1]), from[0] - middle[0]),
               after = std::atan2(-(to[1] - middle[1]), to[0] - middle[0]);
  double angle = after - before;
  angle -= 2 * std::numbers::pi * std::round(angle / (2 * std::numbers::pi));
  if (scene.dimension < 3)
    return angle;
  const Vec3 ahead = looking.view.camera.axes()[2];
  return ahead[axis] > 0 ? -angle : angle;
}

} // namespace maille::live
