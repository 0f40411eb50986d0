#include "maille/base/vectors.hpp"
#include "picture/question_picture.hpp"

#include "body_actors.hpp"
#include "drawing.hpp"
#include "export/body_grid.hpp"
#include "layout.hpp"

#include <fmt/format.h>

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>

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

/// Across the layer. Of images as doctors look at them: the head up and the patient's right to the left, or
/// from the feet. Else the longer side to the right.
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
    if (world_axis(up) < world_axis(right)) // S before A before R
      std::swap(up, right);
    up_sign = direction[world_axis(up)][up] < 0 ? -1 : 1;
    // The patient's right is on the left; seen from the side the front is.
    right_sign = direction[world_axis(right)][right] < 0 ? 1 : -1;
  } else if (side(up) > side(right)) {
    std::swap(up, right);
  }
  view.right = unit(right, right_sign);
  view.up = unit(up, up_sign);
  view.toward = {view.right[1] * view.up[2] - view.right[2] * view.up[1],
                 view.right[2] * view.up[0] - view.right[0] * view.up[2],
                 view.right[0] * view.up[1] - view.right[1] * view.up[0]};
  return view;
}

/// The side of a layer's cells that is towards the viewer, deformed.
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
  std::array<Vec3, 4> of(std::int64_t cell, const Displacement* displacement, double warp) const {
    const Grid& grid = scene_.specimen.grid;
    std::array<Vec3, 4> places{};
    for (std::size_t i = 0; i < 4; ++i) {
      const std::int64_t node = grid.corner(grid.cell_at(cell), corners_[i]);
      places[i] = displacement != nullptr ? drawn_position(scene_, *displacement, warp, node)
                                          : scene_.specimen.position(grid.node_at(node));
    }
    return places;
  }
  vtkSmartPointer<vtkPolyData> shape(const Displacement* displacement, double warp) const {
    vtkNew<vtkPoints> points;
    vtkNew<vtkCellArray> quads;
    for (const std::int64_t cell : cells_) {
      quads->InsertNextCell(4);
      for (const Vec3& place : of(cell, displacement, warp))
        quads->InsertCellPoint(points->InsertNextPoint(place.data()));
    }
    auto shape = vtkSmartPointer<vtkPolyData>::New();
    shape->SetPoints(points);
    shape->SetPolys(quads);
    return shape;
  }

private:
  const Scene& scene_;
  const std::vector<std::int64_t>& cells_;
  std::array<int, 4> corners_{};
  std::size_t n_corners_ = 0;
};

/// What must be seen: the layer at rest and as every panel has it.
void frame(View& view, const LayerSide& side, const std::vector<std::int64_t>& cells,
           const std::vector<SlicePanel>& panels, double warp) {
  std::array<double, 3> low{}, high{};
  low.fill(INFINITY);
  high.fill(-INFINITY);
  const std::array<Vec3, 3> directions{view.right, view.up, view.toward};
  const auto include = [&](const Displacement* displacement) {
    for (const std::int64_t cell : cells)
      for (const Vec3& place : side.of(cell, displacement, warp))
        for (std::size_t d = 0; d < 3; ++d) {
          low[d] = std::min(low[d], dot(place, directions[d]));
          high[d] = std::max(high[d], dot(place, directions[d]));
        }
  };
  include(nullptr);
  for (const SlicePanel& panel : panels)
    include(panel.displacement);
  view.centre = {};
  for (std::size_t d = 0; d < 3; ++d)
    for (std::size_t i = 0; i < 3; ++i)
      view.centre[i] += (low[d] + high[d]) / 2 * directions[d][i];
  view.width = high[0] - low[0];
  view.height = high[1] - low[1];
  view.depth = high[2] - low[2];
}

/// What 98 % of the values in the layer do not exceed.
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
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(shape);
  mapper->SetLookupTable(colours);
  mapper->UseLookupTableScalarRangeOn();
  auto actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
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
  frame(view, side, cells, panels, warp);
  const PictureSettings size{.width = settings.width, .largest_height = settings.largest_height};
  PageParts heights;
  heights.label = 2.2;
  const Page page = choose_page(view, panels.size(), size, heights);
  std::string why_not;
  const auto offscreen = OffscreenWindow::open(page.width, page.height, why_not);
  if (offscreen == nullptr)
    return why_not;
  const Scale scale = round_scale(most_shown(panels, cells) / unit);
  const auto colours = viridis(scale.end);
  vtkRenderWindow& window = offscreen->window();
  vtkNew<vtkRenderer> background;
  background->SetBackground(1, 1, 1);
  std::string text = quantity + (warp != 1 ? fmt::format(",  shape drawn × {:g}", warp) : "");
  add_legend(*background, page, *colours, scale, text + ",  grey: at rest");
  const double em = page.text_size;
  add_triad(*background, view, scene, settings.is_anatomical, page, em);
  window.AddRenderer(background);
  const Vec3& spacing = scene.specimen.grid.spacing();
  const bool has_edges =
      page.scale * *std::min_element(spacing.begin(), spacing.begin() + scene.dimension()) >= 7;
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const Box& label = page.labels[i];
    add_text(*background, panels[i].label, label.left + label.width / 2, label.bottom + label.height, em, ink,
             true);
    const Box& box = page.drawings[i];
    vtkNew<vtkRenderer> drawing;
    drawing->SetLayer(1);
    vtkNew<vtkPolyDataMapper> mapper;
    mapper->SetInputData(side.shape(nullptr, 1));
    vtkNew<vtkActor> rest;
    rest->SetMapper(mapper);
    rest->GetProperty()->SetColor(0.88, 0.89, 0.91);
    rest->GetProperty()->LightingOff();
    bring_forward(*rest, view, -(view.width + view.height + view.depth));
    drawing->AddViewProp(rest);
    drawing->AddViewProp(layer_actor(side, panels[i], cells, warp, unit, colours, has_edges));
    aim(*drawing, view, page, box);
    window.AddRenderer(drawing);
  }
  window.Render();
  save(window, png);
  return std::nullopt;
}

} // namespace maille::studies
