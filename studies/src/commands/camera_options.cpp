#include "commands/camera_options.hpp"
#include "maille/base/vectors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>
#include <utility>

namespace maille::studies {

namespace {

/// `n` finite numbers separated by commas.
std::vector<double> numbers_of(const std::string& option, const std::string& text, std::size_t n) {
  std::vector<double> numbers;
  std::istringstream words(text);
  for (std::string word; std::getline(words, word, ',');) {
    const std::size_t from = std::min(word.find_first_not_of(' '), word.size());
    double number = 0;
    const auto [end, error] = std::from_chars(word.data() + from, word.data() + word.size(), number);
    if (error != std::errc{} || end != word.data() + word.size() || !std::isfinite(number))
      throw UsageError(
          fmt::format("{}: expected {} finite numbers parted by commas, found \"{}\"", option, n, text));
    numbers.push_back(number);
  }
  if (numbers.size() != n)
    throw UsageError(
        fmt::format("{}: expected {} finite numbers parted by commas, found \"{}\"", option, n, text));
  return numbers;
}

Vec3 vector_at(const std::vector<double>& numbers, std::size_t from) {
  return {numbers[from], numbers[from + 1], numbers[from + 2]};
}

Vec3 direction_of(const std::string& option, const std::string& text) {
  const Vec3 direction = vector_at(numbers_of(option, text, 3), 0);
  if (direction == Vec3{})
    throw UsageError(option + ": expected a direction, found " + text);
  return direction;
}

bool is_parallel(const Vec3& a, const Vec3& b) {
  return norm(cross(a, b)) <= 1e-9 * norm(a) * norm(b);
}

} // namespace

render::View view_of(const CameraOptions& options, std::span<const render::SceneObject> objects) {
  for (const auto& [option, number] :
       {std::pair("--zoom", options.zoom), std::pair("--samples", options.samples),
        std::pair("--depth-cue", options.depth_cue)})
    if (!std::isfinite(number))
      throw UsageError(fmt::format("{}: expected a finite number, found {}", option, number));
  render::View view;
  view.width = options.width;
  view.height = options.height;
  view.samples_per_voxel = options.samples;
  view.depth_cue = options.depth_cue;
  view.light = direction_of("--light", options.light);
  if (options.camera) {
    const auto numbers = numbers_of("--camera", *options.camera, 10);
    view.camera.position = vector_at(numbers, 0);
    view.camera.focal_point = vector_at(numbers, 3);
    view.camera.view_up = vector_at(numbers, 6);
    view.camera.view_angle = numbers[9];
    view.camera.parallel = options.parallel;
    const Vec3 ahead{numbers[3] - numbers[0], numbers[4] - numbers[1], numbers[5] - numbers[2]};
    if (!(numbers[9] > 0 && numbers[9] < 180))
      throw UsageError(
          fmt::format("--camera: expected a view angle from 0 to 180 degrees, found {}", numbers[9]));
    if (is_parallel(ahead, view.camera.view_up))
      throw UsageError("--camera: expected a view up that is not along the line of sight");
    view.camera.parallel_scale =
        std::hypot(ahead[0], ahead[1], ahead[2]) * std::tan(numbers[9] * 3.14159265358979323846 / 360);
  } else {
    Vec3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
    for (const render::SceneObject& object : objects)
      if (const auto box = bounds_of(object))
        for (std::size_t a = 0; a < 3; ++a) {
          low[a] = std::min(low[a], box->low[a]);
          high[a] = std::max(high[a], box->high[a]);
        }
    const Vec3 direction = direction_of("--direction", options.direction);
    const Vec3 up = direction_of("--up", options.up);
    if (is_parallel(direction, up))
      throw UsageError("--up: expected a direction that is not along the line of sight, found " + options.up);
    view.camera = render::seeing(low, high, direction, up,
                                 static_cast<double>(options.width) / options.height, options.parallel);
  }
  view.camera = view.camera.zoomed(options.zoom);
  for (const std::string& clip : options.clips) {
    const auto numbers = numbers_of("--clip", clip, 6);
    if (vector_at(numbers, 3) == Vec3{})
      throw UsageError("--clip: expected a point and a normal, found " + clip);
    view.clips.push_back({vector_at(numbers, 0), vector_at(numbers, 3)});
  }
  return view;
}

std::optional<render::CropBox> crop_of(const CameraOptions& options) {
  if (!options.crop)
    return std::nullopt;
  const auto numbers = numbers_of("--crop", *options.crop, 6);
  const render::CropBox box{vector_at(numbers, 0), vector_at(numbers, 3)};
  for (std::size_t a = 0; a < 3; ++a)
    if (!(box.low[a] < box.high[a]))
      throw UsageError("--crop: expected the lower corner first, found " + *options.crop);
  return box;
}

Rgb background_of(const CameraOptions& options) {
  const auto colour = parse_colour(options.background);
  if (!colour)
    throw UsageError("--background: expected a colour \"#rrggbb\", found \"" + options.background + "\"");
  return *colour;
}

render::Picture for_two_eyes(const std::string& stereo, const render::Picture& left,
                             const render::Picture& right, const Rgb& background) {
  return stereo == "anaglyph" ? anaglyph(left, right, background) : side_by_side(left, right);
}

void check_eye(const render::View& view, std::span<const render::SceneObject> objects) {
  const Vec3& eye = view.camera.position;
  for (std::size_t o = 0; o < objects.size() && !view.camera.parallel; ++o) {
    const render::SceneObject& object = objects[o];
    const Vec3 at = object.pose.to_object(eye);
    bool is_inside = false;
    if (object.deformation) {
      const auto box = bounds_of(object);
      is_inside = true;
      for (std::size_t a = 0; a < 3; ++a)
        is_inside = is_inside && eye[a] > box->low[a] && eye[a] < box->high[a];
      // Check only near its cells: a body may surround the eye without touching it.
      const render::Lattice& lattice = object.deformation->lattice();
      double nearest = 1e300;
      for (std::int64_t node = 0; is_inside && node < lattice.n_nodes(); ++node) {
        const Vec3 x = object.deformation->position(node);
        nearest = std::min(nearest, std::hypot(x[0] - at[0], x[1] - at[1], x[2] - at[2]));
      }
      is_inside =
          is_inside && nearest < std::min({lattice.spacing[0], lattice.spacing[1], lattice.spacing[2]});
    } else {
      const double value = object.volume->value_at(object.volume->grid().index_of(at));
      is_inside = object.look->mode == LookMode::isosurface
                      ? value > object.look->isovalue
                      : object.look->opacity_at(value) > 0 && value > object.volume->low();
    }
    if (is_inside)
      throw UsageError(
          fmt::format("--camera: expected an eye outside of what is seen, found it inside of object {}, "
                      "at {}, {}, {} m",
                      o + 1, eye[0], eye[1], eye[2]));
  }
}

} // namespace maille::studies
