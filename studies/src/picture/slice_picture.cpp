#include "maille/base/vectors.hpp"
#include "picture/question_picture.hpp"

#include "body_actors.hpp"
#include "drawing.hpp"
#include "export/body_grid.hpp"
#include "layout.hpp"

#include <fmt/format.h>

#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace maille::studies {

namespace {

Vec3 unit(std::size_t axis, double sign = 1) {
  Vec3 e{};
  e[axis] = sign;
  return e;
}

std::vector<std::int64_t> cells_of(const Scene& scene, const Slice& slice) {
  std::vector<std::int64_t> cells;
  const Grid& grid = scene.specimen.grid;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell)
    if (scene.specimen.is_matter(cell) && grid.cell_at(cell)[slice.axis] == slice.index)
      cells.push_back(cell);
  return cells;
}

/// View across the layer. Images in radiological convention: the head up and the patient's right on the left,
/// or seen from the feet. Otherwise the longer side is horizontal.
View view_across(const Scene& scene, std::size_t normal) {
  View view;
  const Grid& grid = scene.specimen.grid;
  std::size_t right = (normal + 1) % 3, up = (normal + 2) % 3;
  const auto side = [&](std::size_t axis) { return grid.cells()[axis] * grid.spacing()[axis]; };
  double right_sign = 1, up_sign = 1;
  if (scene.specimen.shape == "image") {
    const auto& direction = scene.specimen.placement.direction;
    const auto world_axis = [&](std::size_t axis) {
      std::size_t largest = 0;
      for (std::size_t row = 1; row < 3; ++row)
        if (std::abs(direction[row][axis]) > std::abs(direction[largest][axis]))
          largest = row;
      return largest;
    };
    if (world_axis(up) < world_axis(right)) // preference for up: S, then A, then R
      std::swap(up, right);
    up_sign = direction[world_axis(up)][up] < 0 ? -1 : 1;
    // The patient's right is on the left; in side views the front is.
    right_sign = direction[world_axis(right)][right] < 0 ? 1 : -1;
  } else if (side(up) > side(right)) {
    std::swap(up, right);
  }
  view.right = unit(right, right_sign);
  view.up = unit(up, up_sign);
  view.toward = cross(view.right, view.up);
  return view;
}

/// The deformed side of a layer's cells that faces the viewer.
class LayerSide {
public:
  LayerSide(const Scene& scene, const std::vector<std::int64_t>& cells, const Slice& slice, const View& view)
      : scene_(scene), cells_(cells) {
    const std::size_t normal = slice.axis;
    const std::size_t a = (normal + 1) % 3, b = (normal + 2) % 3;
    const int upper = scene.dimension() == 3 && view.toward[normal] > 0 ? 1 : 0;
    for (const auto& [u, v] : {std::pair(0, 0), std::pair(1, 0), std::pair(1, 1), std::pair(0, 1)})
      corners_[n_corners_++] = (u << a) + (v << b) + (upper << normal);
  }
  Shape of(std::int64_t cell, const Displacement* displacement, double warp) const {
    const Grid& grid = scene_.specimen.grid;
    Shape places;
    for (const int corner : corners_) {
      const std::int64_t node = grid.corner(grid.cell_at(cell), corner);
      places.push_back(displacement != nullptr ? drawn_position(scene_, *displacement, warp, node)
                                               : scene_.specimen.position(grid.node_at(node)));
    }
    return places;
  }
  vtkSmartPointer<vtkPolyData> shape(const Displacement* displacement, double warp) const {
    std::vector<Shape> quads;
    for (const std::int64_t cell : cells_)
      quads.push_back(of(cell, displacement, warp));
    return data_of(quads);
  }

private:
  const Scene& scene_;
  const std::vector<std::int64_t>& cells_;
  std::array<int, 4> corners_{};
  std::size_t n_corners_ = 0;
};

/// 98th percentile of the values in the layer.
double most_shown(const std::vector<SlicePanel>& panels, const std::vector<std::int64_t>& cells) {
  std::vector<double> values;
  for (const SlicePanel& panel : panels)
    for (const std::int64_t cell : cells)
      if (const double value = panel.values[cell]; std::isfinite(value))
        values.push_back(value);
  if (values.empty())
    return 0;
  const auto place =
      values.begin() + static_cast<std::ptrdiff_t>(0.98 * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, place);
  return *place;
}

vtkSmartPointer<vtkActor> layer_actor(const LayerSide& side, const SlicePanel& panel,
                                      const std::vector<std::int64_t>& cells, double warp, double unit,
                                      vtkColorTransferFunction* colours, bool has_edges) {
  const auto shape = side.shape(panel.displacement, warp);
  vtkNew<vtkDoubleArray> values;
  for (const std::int64_t cell : cells)
    values->InsertNextValue(panel.values[cell] / unit);
  shape->GetCellData()->SetScalars(values);
  const auto actor = surface_actor(shape, {1, 0});
  colour_by(*actor, *colours);
  actor->GetProperty()->LightingOff();
  if (has_edges) {
    actor->GetProperty()->EdgeVisibilityOn();
    actor->GetProperty()->SetEdgeColor(0.35, 0.37, 0.42);
  }
  return actor;
}

} // namespace

Slice middle_slice(const Scene& scene) {
  const Grid& grid = scene.specimen.grid;
  Slice slice;
  const auto side = [&](std::size_t axis) { return grid.cells()[axis] * grid.spacing()[axis]; };
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (side(axis) < side(static_cast<std::size_t>(slice.axis)))
      slice.axis = static_cast<int>(axis);
  const std::size_t normal = slice.axis;
  std::vector<std::int64_t> matter(grid.cells()[normal]);
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell)
    if (scene.specimen.is_matter(cell))
      ++matter[grid.cell_at(cell)[normal]];
  const auto n = static_cast<std::ptrdiff_t>(matter.size());
  const auto most = std::max_element(matter.begin() + n / 2, matter.begin() + std::max(n / 2 + 1, 2 * n / 3));
  slice.index = most - matter.begin();
  return slice;
}

std::optional<std::string> render_slice(const Scene& scene, const std::vector<SlicePanel>& panels,
                                        const std::string& quantity, double unit,
                                        const std::filesystem::path& png,
                                        const QuestionPictureSettings& settings) {
  if (scene.dimension() < 2 || panels.empty())
    throw std::invalid_argument("render_slice: expected panels of a body of two or three dimensions");
  std::vector<PicturePanel> answers;
  for (const SlicePanel& panel : panels) {
    PicturePanel& answer = answers.emplace_back();
    answer.displacement = panel.displacement;
  }
  const Slice slice = scene.dimension() == 3 ? middle_slice(scene) : Slice{2, 0};
  const std::vector<std::int64_t> cells = cells_of(scene, slice);
  const double warp = chosen_warp(scene, answers);
  View view = scene.dimension() == 3 ? view_across(scene, static_cast<std::size_t>(slice.axis)) : View{};
  const LayerSide side(scene, cells, slice, view);
  SeenBox seen(view);
  const auto include = [&](const Displacement* displacement) {
    for (const std::int64_t cell : cells)
      for (const Vec3& place : side.of(cell, displacement, warp))
        seen.include(place);
  };
  include(nullptr);
  for (const SlicePanel& panel : panels)
    include(panel.displacement);
  seen.fit(view);
  const PictureSettings size{.width = settings.width, .largest_height = settings.largest_height};
  PageParts heights;
  heights.label = 2.2;
  const Page page = choose_page(view, panels.size(), size, heights);
  std::string why_not;
  const auto sheet = Sheet::open(page, view, why_not);
  if (sheet == nullptr)
    return why_not;
  const Scale scale = round_scale(most_shown(panels, cells) / unit);
  const auto colours = viridis(scale.end);
  const std::string text = quantity + (warp != 1 ? fmt::format(",  shape drawn × {:g}", warp) : "");
  add_legend(sheet->paper(), page, *colours, scale, text + ",  grey: at rest");
  add_triad(sheet->paper(), view, scene, settings.is_anatomical, page, page.text_size);
  const bool has_edges = page.scale * least_spacing(scene.specimen.grid) >= 7;
  for (std::size_t i = 0; i < panels.size(); ++i) {
    sheet->write_under(i, panels[i].label, ink, true);
    const auto rest = flat_actor(side.shape(nullptr, 1), grey_at_rest);
    bring_forward(*rest, view, -(view.width + view.height + view.depth));
    sheet->draw(i, {rest, layer_actor(side, panels[i], cells, warp, unit, colours, has_edges)});
  }
  sheet->save(png);
  return std::nullopt;
}

} // namespace maille::studies
