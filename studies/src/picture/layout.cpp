#include "layout.hpp"
#include "export/body_numbering.hpp"
#include "maille/base/vectors.hpp"
#include "maille/materials/toml_reader.hpp"
#include "picture/question_picture.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace maille::studies {
namespace {

Vec3 combine(double a, const Vec3& x, double b, const Vec3& y, double c, const Vec3& z) {
  return {a * x[0] + b * y[0] + c * z[0], a * x[1] + b * y[1] + c * z[1], a * x[2] + b * y[2] + c * z[2]};
}

Vec3 axis_vector(std::size_t axis) {
  Vec3 e{};
  e[axis] = 1;
  return e;
}

/// Directions of a view of an image: its world's z axis upright (head up), seen along its y axis (from the
/// front), a little from the side and from above. A mirrored image is drawn mirrored.
View upright(const Placement& placement) {
  const View in_world = looking({-1, 0, 0}, {0, 0, 1}, 26, 12);
  View view;
  view.toward = to_object(placement, in_world.toward);
  view.up = to_object(placement, in_world.up);
  view.right = cross(view.up, view.toward);
  return view;
}

std::size_t longest_axis(const Grid& grid) {
  std::size_t longest = 0;
  for (int axis = 1; axis < grid.dimension(); ++axis)
    if (grid.cells()[axis] * grid.spacing()[axis] > grid.cells()[longest] * grid.spacing()[longest])
      longest = axis;
  return longest;
}

/// Drawn thickness of one-dimensional bodies, and space for their rest shape below.
constexpr double line_room_ratio = 0.08;

} // namespace

double longest_side(const Scene& scene) {
  const Grid& grid = scene.specimen.grid;
  const std::size_t axis = longest_axis(grid);
  return grid.cells()[axis] * grid.spacing()[axis];
}

double least_spacing(const Grid& grid) {
  return *std::min_element(grid.spacing().begin(), grid.spacing().begin() + grid.dimension());
}

View looking(const Vec3& along, const Vec3& upright, double turn, double tilt) {
  constexpr double degree = std::numbers::pi / 180;
  const Vec3 front = cross(along, upright);
  const double c = std::cos(turn * degree), s = std::sin(turn * degree), ahead = std::cos(tilt * degree);
  View view;
  view.right = combine(c, along, -s, front, 0, upright);
  view.toward = combine(ahead * s, along, ahead * c, front, std::sin(tilt * degree), upright);
  view.up = cross(view.toward, view.right);
  return view;
}

void SeenBox::include(const Vec3& position) {
  for (std::size_t d = 0; d < 3; ++d) {
    low_[d] = std::min(low_[d], dot(position, directions_[d]));
    high_[d] = std::max(high_[d], dot(position, directions_[d]));
  }
}

void SeenBox::fit(View& view) const {
  const auto middle = [&](std::size_t d) { return (low_[d] + high_[d]) / 2; };
  view.centre = combine(middle(0), directions_[0], middle(1), directions_[1], middle(2), directions_[2]);
  view.width = high_[0] - low_[0];
  view.height = high_[1] - low_[1];
  view.depth = high_[2] - low_[2];
}

double length_of(const Displacement& displacement, std::int64_t node) {
  double squares = 0;
  for (const double value : displacement.at(node))
    squares += value * value;
  return std::sqrt(squares);
}

const Displacement& shown_by_colour(const PicturePanel& panel) {
  return panel.coloured != nullptr ? *panel.coloured : *panel.displacement;
}

namespace {

double largest_of(const Scene& scene, const Displacement& field) {
  double largest = 0;
  for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node)
    if (const double length = length_of(field, node); std::isfinite(length))
      largest = std::max(largest, length);
  return largest;
}

} // namespace

double largest_length(const Scene& scene, const std::vector<PicturePanel>& panels) {
  double largest = 0;
  for (const PicturePanel& panel : panels)
    largest = std::max(largest, largest_of(scene, *panel.displacement));
  return largest;
}

double largest_shown(const Scene& scene, const std::vector<PicturePanel>& panels) {
  double largest = 0;
  for (const PicturePanel& panel : panels)
    largest = std::max(largest, largest_of(scene, shown_by_colour(panel)));
  return largest;
}

double chosen_warp(const Scene& scene, const std::vector<PicturePanel>& panels) {
  constexpr double visible = 0.03, most = 0.12;
  const double ratio = largest_length(scene, panels) / longest_side(scene);
  if (!(ratio > 0) || ratio >= visible)
    return 1;
  const double decade = std::pow(10.0, std::floor(std::log10(most / ratio)));
  const double digit = most / ratio / decade;
  return decade * (digit >= 5 ? 5 : digit >= 2 ? 2 : 1);
}

Vec3 drawn_position(const Scene& scene, const Displacement& displacement, double warp, std::int64_t node) {
  Vec3 position = scene.specimen.position(scene.specimen.grid.node_at(node));
  if (std::isfinite(length_of(displacement, node)))
    for (std::size_t axis = 0; axis < displacement.n_components(); ++axis)
      position[axis] += warp * displacement(axis, node);
  return position;
}

View choose_view(const Scene& scene, const std::vector<PicturePanel>& panels, double warp,
                 const std::vector<std::int64_t>& nodes, const std::vector<Vec3>& also) {
  View view;
  const std::size_t longest = longest_axis(scene.specimen.grid);
  if (scene.dimension() == 3)
    view = scene.specimen.shape == "image"
               ? upright(scene.specimen.placement)
               : looking(axis_vector(longest), axis_vector(longest == 2 ? 1 : 2), 26, 20);
  SeenBox seen(view);
  for (const std::int64_t node : nodes) {
    seen.include(scene.specimen.position(scene.specimen.grid.node_at(node)));
    for (const PicturePanel& panel : panels)
      seen.include(drawn_position(scene, *panel.displacement, warp, node));
  }
  std::ranges::for_each(also, [&](const Vec3& point) { seen.include(point); });
  seen.fit(view);
  if (scene.dimension() == 1)
    view.height = line_room_ratio * view.width;
  return view;
}

std::array<std::array<double, 2>, 3> world_axes(const View& view, const Placement& placement) {
  std::array<std::array<double, 2>, 3> axes{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Vec3 direction = to_object(placement, axis_vector(axis));
    axes[axis] = {dot(direction, view.right), dot(direction, view.up)};
  }
  return axes;
}

Page choose_page(const View& view, std::size_t n_panels, const PictureSettings& settings,
                 const PageParts& parts) {
  Page page;
  page.width = std::max(settings.width, 200);
  page.text_size = page.width / 62.0;
  const double margin = page.text_size, label_height = parts.label * page.text_size;
  const double title_height = settings.title.empty() ? 0 : 2.2 * page.text_size;
  const double legend_height = parts.legend * page.text_size;
  const double fixed_height = 2 * margin + title_height + legend_height;

  std::size_t columns = 1;
  const auto rows_of = [&](std::size_t n_columns) { return (n_panels + n_columns - 1) / n_columns; };
  const auto width_of = [&](std::size_t n_columns) {
    return (page.width - margin) / static_cast<double>(n_columns) - margin;
  };
  for (std::size_t n_columns = n_panels; n_columns > 0; --n_columns) {
    const auto rows = static_cast<double>(rows_of(n_columns));
    const double room =
        (std::max(settings.largest_height, 200) - fixed_height) / rows - label_height - margin;
    const double scale = std::min(0.97 * width_of(n_columns) / view.width, room / view.height);
    if (scale > page.scale * 1.0001) {
      page.scale = scale;
      columns = n_columns;
    }
  }

  const double drawing_height = page.scale * view.height + margin;
  const double row_height = drawing_height + label_height;
  page.height =
      static_cast<int>(std::ceil(fixed_height + static_cast<double>(rows_of(columns)) * row_height));
  page.legend = {margin, margin, page.width - 2 * margin, legend_height};
  page.title = {margin, page.height - margin - title_height, page.width - 2 * margin, title_height};
  for (std::size_t i = 0; i < n_panels; ++i) {
    const std::size_t row = i / columns, column = i % columns;
    const std::size_t in_row = std::min(columns, n_panels - row * columns);
    const double room = (page.width - margin) / static_cast<double>(in_row);
    const double top = page.height - margin - title_height - static_cast<double>(row) * row_height;
    const Box drawing{margin + static_cast<double>(column) * room, top - drawing_height, room - margin,
                      drawing_height};
    page.drawings.push_back(drawing);
    page.labels.push_back({drawing.left, drawing.bottom - label_height, drawing.width, label_height});
  }
  return page;
}

Scale round_scale(double largest) {
  if (!(largest > 0))
    return {};
  const double wanted_step = largest / 5;
  const double decade = std::pow(10.0, std::floor(std::log10(wanted_step)));
  double step = 10 * decade;
  for (const double digit : {1.0, 2.0, 2.5, 5.0})
    if (digit * decade >= wanted_step * (1 - 1e-9)) {
      step = digit * decade;
      break;
    }
  const int steps = std::max(1, static_cast<int>(std::ceil(largest / step * (1 - 1e-9))));
  return {step * steps, steps};
}

bool is_scene_of_a_patient(std::string_view text) {
  try {
    const toml::table root = parse_toml(text, "scene");
    const auto image = root["specimen"]["image"].value<std::string>();
    return image && (image->ends_with(".nii") || image->ends_with(".nii.gz"));
  } catch (const InputError&) {
    return false;
  }
}

} // namespace maille::studies
