// Validates the request of a picture, and casts each object's part of it.

#include "prepare/request.hpp"
#include "maille/base/vectors.hpp"

#include "data/parallel.hpp"

#include <fmt/format.h>

#include <atomic>
#include <cmath>
#include <stdexcept>
#include <string>

namespace maille::render {

namespace {

bool is_finite(const Vec3& v) {
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}

void check(const View& view) {
  const auto refuse = [](const std::string& what) { throw std::invalid_argument(what); };
  constexpr std::int64_t most_pixels = std::int64_t{1} << 28;
  if (view.width < 1 || view.height < 1 || std::int64_t{view.width} * view.height > most_pixels)
    refuse(fmt::format("a picture has 1 to {} pixels, not {} x {}", most_pixels, view.width, view.height));
  const Camera& camera = view.camera;
  if (!is_finite(camera.position) || !is_finite(camera.focal_point) || !is_finite(camera.view_up))
    refuse("the camera is nowhere: numbers that are not finite");
  const Vec3 ahead = minus(camera.focal_point, camera.position);
  if (!(length(ahead) > 0))
    refuse("the camera is at its focal point");
  if (!(length(cross(ahead, camera.view_up)) > 1e-9 * length(ahead) * length(camera.view_up)))
    refuse("the camera's view up is along its line of sight");
  if (camera.parallel ? !(camera.parallel_scale > 0 && std::isfinite(camera.parallel_scale))
                      : !(camera.view_angle > 0 && camera.view_angle < 180))
    refuse(camera.parallel ? "the camera's parallel scale is a length > 0"
                           : "the camera's view angle is from 0 to 180 degrees");
  if (!(view.samples_per_voxel > 0 && view.samples_per_voxel <= 64))
    refuse("samples a voxel: a number above 0, at most 64");
  if (!(view.depth_cue >= 0 && view.depth_cue <= 1))
    refuse("a depth cue is from 0 to 1");
  if (!is_finite(view.light) || !(length(view.light) > 0))
    refuse("light comes from a direction");
  for (const ClipPlane& plane : view.clips)
    if (!is_finite(plane.point) || !is_finite(plane.normal) || !(length(plane.normal) > 0))
      refuse("a clip plane has a point and a normal");
}

void check(const SceneObject& object, std::size_t number) {
  const auto refuse = [&](const char* what) {
    throw std::invalid_argument(fmt::format("object {} of the picture: {}", number, what));
  };
  if (!object.volume || !object.look)
    refuse("no volume or no look");
  if (object.look->colours.empty() || object.look->opacity.empty())
    refuse("a look without colours or opacity");
  if (object.volume->grid().n_voxels() > std::int64_t{1} << 29)
    refuse("more than 2^29 voxels");
  if (!is_finite(object.pose.position))
    refuse("a pose that is not finite");
}

} // namespace

void check_request(std::span<const SceneObject> objects, const View& view) {
  check(view);
  for (std::size_t o = 0; o < objects.size(); ++o)
    check(objects[o], o);
}

std::int64_t cast_tiles(const PreparedObject& prepared, const View& view, int threads,
                        std::vector<TileRuns>& tiles) {
  const int tiles_x = tiles_along(view.width), tiles_y = tiles_along(view.height);
  tiles.resize(static_cast<std::size_t>(tiles_x) * tiles_y);
  const PixelBox& box = prepared.box();
  std::vector<int> seen;
  for (int ty = 0; ty < tiles_y; ++ty)
    for (int tx = 0; tx < tiles_x; ++tx) {
      const int tile = tx + tiles_x * ty;
      if (!box.empty() && tx * tile_edge < box.x1 && (tx + 1) * tile_edge > box.x0 &&
          ty * tile_edge < box.y1 && (ty + 1) * tile_edge > box.y0)
        seen.push_back(tile);
      else
        tiles[tile] = {};
    }
  std::vector<RunSink> sinks(threads);
  std::atomic<std::int64_t> rays{0};
  for_each_item(threads, static_cast<int>(seen.size()), [&](int item, int thread) {
    RunSink& sink = sinks[thread];
    const int tile = seen[item];
    sink.clear();
    rays += prepared.cast(tile, sink);
    sink.take(tiles[tile]);
  });
  return rays;
}

} // namespace maille::render
