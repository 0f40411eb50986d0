#include "picture/comparison_picture.hpp"

#include "body_actors.hpp"
#include "drawing.hpp"
#include "export/body_grid.hpp"
#include "layout.hpp"

#include <fmt/format.h>

#include <vtkActor2D.h>
#include <vtkImageData.h>
#include <vtkImageMapper.h>
#include <vtkNew.h>
#include <vtkRenderer.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>

namespace maille::studies {
namespace fs = std::filesystem;
namespace {

void require_fit(const Scene& scene, const std::vector<PicturePanel>& panels) {
  const std::size_t n_nodes = scene.specimen.grid.n_nodes();
  for (const PicturePanel& panel : panels) {
    const auto fits = [&](const Displacement& field) {
      return field.n_components() == static_cast<std::size_t>(scene.dimension()) &&
             field.n_nodes() == n_nodes;
    };
    if (panel.displacement == nullptr || !fits(*panel.displacement) || !fits(shown_by_colour(panel)))
      throw std::invalid_argument(
          fmt::format("render_comparison: panel {} has no displacement on the grid of scene {}", panel.label,
                      scene.name));
  }
}

struct LengthUnit {
  double metres = 1e-3; ///< or the unit of other coloured quantities
  std::string name = "mm";
};

/// Unit of lengths: millimetres, unless they need many digits.
LengthUnit unit_for(double largest) {
  if (largest >= 1)
    return {1, "m"};
  if (largest > 0 && largest < 1e-5)
    return {1e-6, "µm"};
  return {};
}

std::string note_of(const PicturePanel& panel) {
  if (panel.is_reference)
    return "reference";
  if (panel.relative_l2)
    return fmt::format("relative L2 error {:.3g} %", 100 * *panel.relative_l2);
  return "";
}

std::string legend_text(const std::string& quantity, const LengthUnit& unit, double warp,
                        bool has_nonfinite) {
  std::string text = fmt::format("{} in {}", quantity, unit.name);
  if (warp != 1)
    text += fmt::format(",  shape drawn × {:g}", warp);
  return text + ",  grey: at rest" + (has_nonfinite ? ",  red: not finite" : "");
}

bool is_nonfinite(const PicturePanel& panel) {
  return std::ranges::any_of(panel.displacement->values(), [](double u) { return !std::isfinite(u); });
}

/// Box of a body drawn by `draw`.
vtkSmartPointer<vtkActor2D> drawn_body(const PicturePanel& panel, const DrawBody& draw, const View& view,
                                       double warp, const Page& page, const Box& box) {
  PanelView of{view.right, view.up, view.toward, view.centre, page.scale};
  of.width = std::max(1, static_cast<int>(box.width));
  of.height = std::max(1, static_cast<int>(box.height));
  of.warp = warp;
  const std::vector<std::uint8_t> rgb = draw(*panel.displacement, of);
  vtkNew<vtkImageData> image;
  image->SetDimensions(of.width, of.height, 1);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  const auto row = static_cast<std::ptrdiff_t>(3) * of.width;
  for (int y = 0; y < of.height; ++y) // VTK's rows start at the bottom
    std::copy_n(rgb.begin() + row * y, row,
                static_cast<std::uint8_t*>(image->GetScalarPointer(0, of.height - 1 - y, 0)));
  vtkNew<vtkImageMapper> mapper;
  mapper->SetInputData(image);
  mapper->SetColorWindow(255);
  mapper->SetColorLevel(127.5);
  auto actor = vtkSmartPointer<vtkActor2D>::New();
  actor->SetMapper(mapper);
  actor->SetPosition(box.left, box.bottom);
  return actor;
}

} // namespace

std::optional<std::string> render_comparison(const Scene& scene, const std::vector<PicturePanel>& panels,
                                             const fs::path& png, const PictureSettings& settings) {
  if (panels.empty())
    throw std::invalid_argument("render_comparison: no panels");
  std::vector<PicturePanel> in_view = panels;
  in_view.insert(in_view.end(), settings.also_in_view.begin(), settings.also_in_view.end());
  require_fit(scene, in_view);
  const double warp = settings.warp.value_or(chosen_warp(scene, in_view));
  const View view = choose_view(scene, in_view, warp, matter_only(scene.specimen).nodes);
  const Page page = choose_page(view, panels.size(), settings);

  std::string why_not;
  const auto sheet = Sheet::open(page, view, why_not);
  if (sheet == nullptr)
    return why_not;

  const double largest = largest_shown(scene, in_view);
  const LengthUnit unit = settings.unit ? LengthUnit{*settings.unit, settings.unit_name} : unit_for(largest);
  const Scale scale = round_scale(largest / unit.metres);
  const auto colours = viridis(scale.end);
  const BodyStyle style{warp, unit.metres, colours, page.scale, std::max(1.0, page.width / 1600.0)};

  sheet->add_title(settings.title);
  if (settings.draw_body)
    add_text(sheet->paper(), warp == 1 ? "" : fmt::format("shape drawn × {:g}", warp), page.width / 2.0,
             page.legend.bottom + page.legend.height, 0.82 * page.text_size, quiet_ink, false);
  else
    add_legend(
        sheet->paper(), page, *colours, scale,
        legend_text(settings.quantity, unit, warp, std::any_of(panels.begin(), panels.end(), is_nonfinite)));
  add_triad(sheet->paper(), view, scene, settings.is_anatomical, page, page.text_size);
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const PicturePanel& panel = panels[i];
    sheet->write_under(i, panel.label, ink, true);
    if (const std::string note = note_of(panel); !note.empty())
      sheet->write_under(i, note, quiet_ink, false, 1.4, 0.82);
    if (settings.draw_body)
      sheet->paper().AddActor2D(drawn_body(panel, settings.draw_body, view, warp, page, page.drawings[i]));
    else
      sheet->draw(i, body_actors(scene, *panel.displacement, shown_by_colour(panel), style, view));
  }
  sheet->save(png);
  return std::nullopt;
}

} // namespace maille::studies
