/// Object under the pointer.

#include "maille/live/picture.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <cstdint>
#include <optional>

namespace maille::live {

namespace {

/// Rest position of a point in a deformed body, by the cell that contains it.
std::optional<Vec3> rest_of(const Specimen& body, const Displacement& by, const Vec3& place) {
  const Grid& grid = body.grid;
  double nearest = 1e300;
  std::optional<Vec3> rest;
  Index3 at{};
  std::int64_t node = 0;
  for (at[2] = 0; at[2] < grid.nodes()[2]; ++at[2])
    for (at[1] = 0; at[1] < grid.nodes()[1]; ++at[1]) {
      const Vec3 row = body.position({0, at[1], at[2]});
      for (at[0] = 0; at[0] < grid.nodes()[0]; ++at[0], ++node) {
        double squared = 0;
        for (int a = 0; a < grid.dimension(); ++a) {
          const double x = a == 0 ? row[0] + at[0] * grid.spacing()[0] : row[a];
          squared += (x + by(a, node) - place[a]) * (x + by(a, node) - place[a]);
        }
        if (squared < nearest && body.is_node(at)) {
          const Vec3 u = by.at(node);
          nearest = squared;
          rest = Vec3{place[0] - u[0], place[1] - u[1], place[2] - u[2]};
        }
      }
    }
  return rest;
}

} // namespace

std::optional<Painted::Under> Painted::under(double x, double y, double reach) const {
  if (!(x >= 0) || !(x < 1) || !(y >= 0) || !(y < 1) || width < 1 || height < 1 || !state || !scene)
    return std::nullopt;
  double in_eye = x;
  if (looking.stereo == Stereo::side_by_side) // both eyes' pictures are picked in the left one
    in_eye = x < 0.5 ? 2 * x : 2 * x - 1;
  const int eye_width = depth.empty() ? width : static_cast<int>(object.size()) / height;
  const auto pixel_at = [&](int at_x, int at_y) { return static_cast<std::size_t>(at_y) * eye_width + at_x; };
  const auto whose = [&](int at_x, int at_y) {
    const std::size_t pixel = pixel_at(at_x, at_y);
    const std::int32_t found = pixel < object.size() ? object[pixel] : -1;
    return found < static_cast<std::int32_t>(scene->objects.size()) ? found : -1;
  };
  const auto is_movable = [&](std::int32_t which) {
    return which >= 0 && scene->objects[which].kind != ObjectKind::fixed;
  };
  int px = std::min(eye_width - 1, static_cast<int>(in_eye * eye_width)),
      py = std::min(height - 1, static_cast<int>(y * height));
  if (const int far = static_cast<int>(reach); far > 0 && !is_movable(whose(px, py))) {
    int least = far * far + 1;
    const int middle_x = px, middle_y = py;
    for (int at_y = std::max(0, middle_y - far); at_y <= std::min(height - 1, middle_y + far); ++at_y)
      for (int at_x = std::max(0, middle_x - far); at_x <= std::min(eye_width - 1, middle_x + far); ++at_x) {
        const int squared = (at_x - middle_x) * (at_x - middle_x) + (at_y - middle_y) * (at_y - middle_y);
        if (squared < least && is_movable(whose(at_x, at_y))) {
          least = squared;
          px = at_x;
          py = at_y;
        }
      }
  }
  Under under;
  under.object = whose(px, py);
  if (under.object < 0)
    return std::nullopt;
  if (depth.empty()) {
    under.world = flat_point(looking, static_cast<double>(width) / height, x, y);
  } else {
    const render::Ray ray = looking.view.camera.ray(eye_width, height, px, py);
    for (std::size_t a = 0; a < 3; ++a)
      under.world[a] = ray.origin[a] + depth[pixel_at(px, py)] * ray.direction[a];
  }
  const std::size_t i = under.object;
  const deform::Pose& frame = state->frames[i];
  const Eigen::Vector3d own =
      frame.rotation.transpose() *
      (Eigen::Vector3d(under.world[0], under.world[1], under.world[2]) - frame.position);
  under.rest = {own[0], own[1], own[2]};
  if (state->displacements[i])
    if (const auto rest = rest_of(scene->objects[i].scene.specimen, *state->displacements[i], under.rest))
      under.rest = *rest;
  return under;
}

} // namespace maille::live
