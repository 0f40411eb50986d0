#include "drawing.hpp"

#include "export/whole_file.hpp"

#include <fmt/format.h>

#include <vtkActor2D.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkLight.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkProperty2D.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>
#include <vtkUnsignedCharArray.h>
#include <vtkWindowToImageFilter.h>

#include <algorithm>
#include <array>
#include <cmath>
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

/// A bar of the colours over 0 to the scale's end [pixels].
vtkSmartPointer<vtkActor2D> colour_bar(const Box& box, vtkColorTransferFunction& colours, double end) {
  constexpr int n_strips = 256;
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> strips;
  vtkNew<vtkDoubleArray> values;
  for (int i = 0; i <= n_strips; ++i) {
    const double x = box.left + box.width * i / n_strips;
    points->InsertNextPoint(x, box.bottom, 0);
    points->InsertNextPoint(x, box.bottom + box.height, 0);
    if (i == n_strips)
      break;
    const vtkIdType first = 2 * i;
    strips->InsertNextCell({first, first + 2, first + 3, first + 1});
    values->InsertNextValue(end * (i + 0.5) / n_strips);
  }
  vtkNew<vtkPolyData> bar;
  bar->SetPoints(points);
  bar->SetPolys(strips);
  bar->GetCellData()->SetScalars(values);
  vtkNew<vtkPolyDataMapper2D> mapper;
  mapper->SetInputData(bar);
  mapper->SetLookupTable(&colours);
  mapper->UseLookupTableScalarRangeOn();
  auto actor = vtkSmartPointer<vtkActor2D>::New();
  actor->SetMapper(mapper);
  return actor;
}

} // namespace

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
  const double x = page.legend.left + 4 * em, y = page.legend.bottom + 2.2 * em;
  const double length = (is_anatomical ? 1.3 : 1.8) * em;
  constexpr std::array<const char*, 3> names{"x", "y", "z"};
  constexpr std::array<std::array<const char*, 2>, 3> ends{{{"R", "L"}, {"A", "P"}, {"S", "I"}}};
  constexpr std::array<Vec3, 3> colours{{{0.75, 0.15, 0.15}, {0.10, 0.50, 0.20}, {0.15, 0.30, 0.75}}};
  const auto axes = world_axes(view, scene.specimen.placement);
  for (int axis = 0; axis < scene.dimension(); ++axis)
    for (const int sign : {1, -1}) {
      if (sign < 0 && !is_anatomical)
        continue;
      const double dx = sign * length * axes[axis][0], dy = sign * length * axes[axis][1];
      if (std::hypot(dx, dy) < 0.05 * length) // it comes towards the viewer
        continue;
      vtkNew<vtkPoints> points;
      points->InsertNextPoint(x, y, 0);
      points->InsertNextPoint(x + dx, y + dy, 0);
      vtkNew<vtkCellArray> lines;
      lines->InsertNextCell({0, 1});
      vtkNew<vtkPolyData> line;
      line->SetPoints(points);
      line->SetLines(lines);
      vtkNew<vtkPolyDataMapper2D> mapper;
      mapper->SetInputData(line);
      vtkNew<vtkActor2D> actor;
      actor->SetMapper(mapper);
      actor->GetProperty()->SetColor(colours[axis].data());
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

void aim(vtkRenderer& renderer, const View& view, const Page& page, const Box& box) {
  renderer.SetViewport(box.left / page.width, box.bottom / page.height, (box.left + box.width) / page.width,
                       (box.bottom + box.height) / page.height);
  vtkCamera& camera = *renderer.GetActiveCamera();
  const double away = 10 * (view.width + view.height);
  camera.ParallelProjectionOn();
  camera.SetFocalPoint(view.centre.data());
  camera.SetPosition(view.centre[0] + away * view.toward[0], view.centre[1] + away * view.toward[1],
                     view.centre[2] + away * view.toward[2]);
  camera.SetViewUp(view.up.data());
  camera.SetParallelScale(box.height / 2 / page.scale);
  renderer.ResetCameraClippingRange();
}

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

void save(vtkRenderWindow& window, const fs::path& png) {
  vtkNew<vtkWindowToImageFilter> image;
  image->SetInput(&window);
  image->SetInputBufferTypeToRGB();
  image->ReadFrontBufferOff();
  image->Update();
  vtkNew<vtkPNGWriter> writer; // in memory, since it does not notice a full disk
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
