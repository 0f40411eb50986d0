#include "drawing.hpp"

#include "export/whole_file.hpp"

#include <fmt/format.h>

#include <vtkActor.h>
#include <vtkActor2D.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFeatureEdges.h>
#include <vtkLight.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkProperty.h>
#include <vtkProperty2D.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>
#include <vtkUnsignedCharArray.h>
#include <vtkWindowToImageFilter.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string_view>

namespace maille::studies {
namespace fs = std::filesystem;
namespace {

void style_text(vtkTextProperty& property, double size, const Vec3& colour, bool is_bold) {
  property.SetFontFamilyToArial();
  property.SetFontSize(std::max(8, static_cast<int>(std::lround(size))));
  property.SetColor(colour[0], colour[1], colour[2]);
  property.SetBold(is_bold);
  property.SetItalic(false);
  property.SetShadow(false);
}

/// A shape on the page [pixels]. @param colours of its cells' values; null: by its colour alone
vtkSmartPointer<vtkActor2D> on_page(vtkPolyData* shape, const Vec3& colour,
                                    vtkColorTransferFunction* colours = nullptr) {
  vtkNew<vtkPolyDataMapper2D> mapper;
  mapper->SetInputData(shape);
  if (colours != nullptr) {
    mapper->SetLookupTable(colours);
    mapper->UseLookupTableScalarRangeOn();
  }
  auto actor = vtkSmartPointer<vtkActor2D>::New();
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(colour.data());
  return actor;
}

Shape rectangle(const Box& box) {
  const double right = box.left + box.width, top = box.bottom + box.height;
  return {{box.left, box.bottom, 0}, {right, box.bottom, 0}, {right, top, 0}, {box.left, top, 0}};
}

/// A bar of the colours from 0 to the scale's end [pixels].
vtkSmartPointer<vtkActor2D> colour_bar(const Box& box, vtkColorTransferFunction& colours, double end) {
  constexpr int n_strips = 256;
  std::vector<Shape> strips;
  vtkNew<vtkDoubleArray> values;
  for (int i = 0; i < n_strips; ++i) {
    strips.push_back(
        rectangle({box.left + box.width * i / n_strips, box.bottom, box.width / n_strips, box.height}));
    values->InsertNextValue(end * (i + 0.5) / n_strips);
  }
  const auto bar = data_of(strips);
  bar->GetCellData()->SetScalars(values);
  return on_page(bar, ink, &colours);
}

/// A parallel view that fills a box of the page at the page's scale.
void aim(vtkRenderer& renderer, const View& view, const Page& page, const Box& box) {
  renderer.SetViewport(box.left / page.width, box.bottom / page.height, (box.left + box.width) / page.width,
                       (box.bottom + box.height) / page.height);
  vtkCamera& camera = *renderer.GetActiveCamera();
  const double away = 10 * (view.width + view.height);
  camera.ParallelProjectionOn();
  camera.SetFocalPoint(view.centre.data());
  camera.SetPosition(plus(view.centre, away, view.toward).data());
  camera.SetViewUp(view.up.data());
  camera.SetParallelScale(box.height / 2 / page.scale);
  renderer.ResetCameraClippingRange();
}

/// One light from over the viewer's left shoulder and a weaker one from below it, so that the front is not
/// dark.
void add_lights(vtkRenderer& renderer) {
  renderer.AutomaticLightCreationOff();
  const auto add = [&](double x, double y, double z, double intensity) {
    vtkNew<vtkLight> light;
    light->SetLightTypeToCameraLight(); // positions are relative to the camera, at (0, 0, 1)
    light->SetPosition(x, y, z);
    light->SetFocalPoint(0, 0, 0);
    light->SetIntensity(intensity);
    renderer.AddLight(light);
  };
  add(-0.2, 1, 1, 0.55);
  add(0.6, 0, 1, 0.45);
}

} // namespace

vtkSmartPointer<vtkPolyData> data_of(const std::vector<Shape>& shapes, bool are_lines) {
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> cells;
  for (const Shape& shape : shapes) {
    cells->InsertNextCell(static_cast<int>(shape.size()));
    for (const Vec3& corner : shape)
      cells->InsertCellPoint(points->InsertNextPoint(corner.data()));
  }
  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(points);
  are_lines ? data->SetLines(cells) : data->SetPolys(cells);
  return data;
}

Shape disc(const Vec3& at, double radius, const View& view) {
  constexpr int n_corners = 16;
  Shape corners;
  for (int i = 0; i < n_corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / n_corners;
    corners.push_back(
        plus(plus(at, radius * std::cos(angle), view.right), radius * std::sin(angle), view.up));
  }
  return corners;
}

vtkSmartPointer<vtkActor> surface_actor(vtkPolyData* surface, const Shading& shading) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(surface);
  auto actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
  vtkProperty& property = *actor->GetProperty();
  property.SetInterpolationToFlat(); // faces of voxels are flat
  property.SetAmbient(shading.ambient);
  property.SetDiffuse(shading.diffuse);
  property.SetSpecular(0);
  return actor;
}

vtkSmartPointer<vtkActor> flat_actor(vtkPolyData* shape, const Vec3& colour, double opacity) {
  auto actor = surface_actor(shape, {1, 0});
  actor->GetMapper()->ScalarVisibilityOff();
  vtkProperty& property = *actor->GetProperty();
  property.SetColor(colour[0], colour[1], colour[2]);
  property.SetOpacity(opacity);
  property.LightingOff();
  return actor;
}

vtkSmartPointer<vtkActor> edge_actor(vtkPolyData* surface, bool of_every_cell, double opacity,
                                     double line_width, const View& view, double pixels_per_metre) {
  vtkNew<vtkFeatureEdges> edges;
  edges->SetInputData(surface);
  edges->SetFeatureEdges(
      !of_every_cell); // without them edges between two faces, sharp or not, are "manifold"
  edges->SetManifoldEdges(of_every_cell);
  edges->SetNonManifoldEdges(of_every_cell);
  edges->ColoringOff();
  edges->Update();
  const auto actor = flat_actor(edges->GetOutput(), ink, opacity);
  actor->GetProperty()->SetLineWidth(static_cast<float>(line_width));
  constexpr double pixels_forward =
      3; // in front of the faces that they edge, also where those are seen aslant
  bring_forward(*actor, view, pixels_forward * line_width / pixels_per_metre);
  return actor;
}

void add_text(vtkRenderer& renderer, const std::string& text, double x, double y, double size,
              const Vec3& colour, bool is_bold) {
  vtkNew<vtkTextActor> actor;
  actor->SetInput(text.c_str());
  style_text(*actor->GetTextProperty(), size, colour, is_bold);
  actor->GetTextProperty()->SetJustificationToCentered();
  actor->GetTextProperty()->SetVerticalJustificationToTop();
  actor->SetPosition(std::round(x), std::round(y));
  renderer.AddActor2D(actor);
}

void add_triad(vtkRenderer& renderer, const View& view, const Scene& scene, bool is_anatomical,
               const Page& page, double em) {
  // With its letters as high as the legend: what is written under a panel stays free.
  const double x = page.legend.left + 4 * em, y = page.legend.bottom + 1.7 * em, length = 1.1 * em;
  constexpr std::array<const char*, 3> names{"x", "y", "z"};
  constexpr std::array<std::array<const char*, 2>, 3> ends{{{"R", "L"}, {"A", "P"}, {"S", "I"}}};
  constexpr std::array<Vec3, 3> colours{{{0.75, 0.15, 0.15}, {0.10, 0.50, 0.20}, {0.15, 0.30, 0.75}}};
  const auto axes = world_axes(view, scene.specimen.placement);
  for (int axis = 0; axis < scene.dimension(); ++axis)
    for (const int sign : {1, -1}) {
      if (sign < 0 && !is_anatomical)
        continue;
      const double dx = sign * length * axes[axis][0], dy = sign * length * axes[axis][1];
      if (std::hypot(dx, dy) < 0.05 * length) // it points to the viewer
        continue;
      const auto actor = on_page(data_of({{{x, y, 0}, {x + dx, y + dy, 0}}}, true), colours[axis]);
      actor->GetProperty()->SetLineWidth(sign > 0 ? 3 : 1);
      renderer.AddActor2D(actor);
      const double away = 1 + 0.8 * em / std::max(std::hypot(dx, dy), 0.5 * em);
      add_text(renderer, is_anatomical ? ends[axis][sign > 0 ? 0 : 1] : names[axis], x + away * dx,
               y + away * dy + 0.5 * em, 0.8 * em, colours[axis], sign > 0);
    }
}

void bring_forward(vtkActor& actor, const View& view, double distance) {
  actor.SetPosition(distance * view.toward[0], distance * view.toward[1], distance * view.toward[2]);
}

void add_rectangle(vtkRenderer& renderer, const Box& box, const Vec3& colour) {
  renderer.AddActor2D(on_page(data_of({rectangle(box)}), colour));
}

void add_legend(vtkRenderer& renderer, const Page& page, vtkColorTransferFunction& colours,
                const Scale& scale, const std::string& text) {
  const double em = page.text_size;
  const double width = std::min(0.8 * page.legend.width, 32 * em);
  const Box bar{page.legend.left + (page.legend.width - width) / 2, page.legend.bottom + 1.1 * em, width,
                0.9 * em};
  renderer.AddActor2D(colour_bar(bar, colours, scale.end));
  for (int i = 0; i <= scale.steps; ++i)
    add_text(renderer, fmt::format("{:.4g}", scale.end * i / scale.steps),
             bar.left + bar.width * i / scale.steps, bar.bottom - 0.3 * em, 0.78 * em, ink, false);
  add_text(renderer, text, page.width / 2.0, page.legend.bottom + page.legend.height, 0.82 * em, quiet_ink,
           false);
}

std::unique_ptr<Sheet> Sheet::open(const Page& page, const View& view, std::string& why_not) {
  auto window = OffscreenWindow::open(page.width, page.height, why_not);
  return window ? std::unique_ptr<Sheet>(new Sheet(std::move(window), page, view)) : nullptr;
}

Sheet::Sheet(std::unique_ptr<OffscreenWindow> window, const Page& page, const View& view)
    : window_(std::move(window)), page_(page), view_(view) {
  paper_->SetBackground(1, 1, 1);
  window_->window().AddRenderer(paper_);
}

void Sheet::add_title(const std::string& title) {
  if (!title.empty())
    add_text(*paper_, title, page_.width / 2.0, page_.title.bottom + page_.title.height,
             1.1 * page_.text_size, ink, true);
}

void Sheet::write_under(std::size_t panel, const std::string& text, const Vec3& colour, bool is_bold,
                        double lines_down, double size) {
  const Box& box = page_.labels[panel];
  add_text(*paper_, text, box.left + box.width / 2, box.bottom + box.height - lines_down * page_.text_size,
           size * page_.text_size, colour, is_bold);
}

void Sheet::draw(std::size_t panel, const Props& props, const std::optional<Vec3>& background) {
  vtkNew<vtkRenderer> renderer;
  renderer->SetLayer(1); // over the page
  if (background) {
    renderer->SetBackground((*background)[0], (*background)[1], (*background)[2]);
    renderer->EraseOn();
  }
  for (const auto& prop : props)
    renderer->AddViewProp(prop);
  add_lights(*renderer);
  aim(*renderer, view_, page_, page_.drawings[panel]);
  window_->window().AddRenderer(renderer);
}

void Sheet::save(const fs::path& png) {
  window_->window().Render();
  studies::save(window_->window(), png);
}

void save(vtkRenderWindow& window, const fs::path& png) {
  vtkNew<vtkWindowToImageFilter> image;
  image->SetInput(&window);
  image->SetInputBufferTypeToRGB();
  image->ReadFrontBufferOff();
  image->Update();
  vtkNew<vtkPNGWriter> writer; // in memory, because the writer does not detect a full disk
  writer->SetInputConnection(image->GetOutputPort());
  writer->WriteToMemoryOn();
  writer->Write();
  vtkUnsignedCharArray* bytes = writer->GetResult();
  if (bytes == nullptr)
    throw std::runtime_error(fmt::format("cannot write {}: no PNG can be made of the picture", png.string()));
  write_whole(png, std::string_view(reinterpret_cast<const char*>(bytes->GetPointer(0)),
                                    static_cast<std::size_t>(bytes->GetNumberOfValues())));
}

} // namespace maille::studies
