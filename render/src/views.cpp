#include "maille/render/views.hpp"
#include "maille/base/vectors.hpp"

#include "compose/compose.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <stdexcept>

namespace maille::render {

std::array<View, 2> stereo_views(const View& view, const StereoSettings& settings) {
  const auto right = view.camera.axes()[0];
  const double distance = length(minus(view.camera.focal_point, view.camera.position));
  const double separation = settings.separation > 0 ? settings.separation : distance / 30;
  std::array<View, 2> views{view, view};
  for (std::size_t eye = 0; eye < 2; ++eye)
    views[eye].camera.position =
        plus(view.camera.position, times((eye == 0 ? -0.5 : 0.5) * separation, right));
  return views;
}

namespace {

void check_pair(const Picture& left, const Picture& right) {
  if (left.width != right.width || left.height != right.height)
    throw std::invalid_argument("the pictures of two eyes are of one size");
}

} // namespace

Picture side_by_side(const Picture& left, const Picture& right) {
  check_pair(left, right);
  Picture both;
  clear(both, 2 * left.width, left.height);
  for (int y = 0; y < left.height; ++y)
    for (int x = 0; x < both.width; ++x) {
      const Picture& from = x < left.width ? left : right;
      const std::size_t pixel = from.pixel(x % left.width, y), to = both.pixel(x, y);
      both.rgba[to] = from.rgba[pixel];
      both.depth[to] = from.depth[pixel];
      both.object[to] = from.object[pixel];
    }
  return both;
}

Picture anaglyph(const Picture& left, const Picture& right, const Rgb& background) {
  check_pair(left, right);
  Picture both;
  clear(both, left.width, left.height);
  const auto brightness = [&](const std::array<float, 4>& over) {
    constexpr std::array<float, 3> weight{0.2126f, 0.7152f, 0.0722f}; // of Rec. 709's primaries
    float sum = 0;
    for (std::size_t c = 0; c < 3; ++c)
      sum += weight[c] * (over[c] + (1 - over[3]) * background[c]);
    return sum;
  };
  for (std::size_t p = 0; p < both.rgba.size(); ++p) {
    const float of_left = brightness(left.rgba[p]), of_right = brightness(right.rgba[p]);
    both.rgba[p] = {of_left, of_right, of_right, 1};
    both.depth[p] = left.depth[p];
    both.object[p] = left.object[p];
  }
  return both;
}

std::array<const Picture*, 2> StereoRenderer::render(std::span<const SceneObject> objects, const View& view,
                                                     const StereoSettings& settings) {
  const auto views = stereo_views(view, settings);
  return {&eyes_[0].render(objects, views[0]), &eyes_[1].render(objects, views[1])};
}

View view_of_ring(const View& first, int which, int n_views) {
  View view = first;
  view.camera = first.camera.turned(360.0 * which / n_views, 0);
  return view;
}

} // namespace maille::render
