#include "picture/world_picture.hpp"

#include "body_actors.hpp"
#include "drawing.hpp"

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace maille::studies {
namespace {

/// From the front, a little from above and the right.
void look_from_above(View& view) {
  constexpr double turn = 28 * std::numbers::pi / 180, tilt = 24 * std::numbers::pi / 180;
  view.right = {std::cos(turn), std::sin(turn), 0};
  view.toward = {std::sin(turn) * std::cos(tilt), -std::cos(turn) * std::cos(tilt), std::sin(tilt)};
  view.up = {-std::sin(turn) * std::sin(tilt), std::cos(turn) * std::sin(tilt), std::cos(tilt)};
}

/// The whole world, whatever is in it.
View view_of(const WorldScene& world) {
  View view;
  if (world.dimension == 3)
    look_from_above(view);
  Vec3 size{};
  for (int a = 0; a < world.dimension; ++a)
    size[a] = world.cells[a] * world.spacing[a];
  view.centre = {size[0] / 2, size[1] / 2, size[2] / 2};
  const auto extent = [&](const Vec3& direction) {
    double sum = 0;
    for (std::size_t a = 0; a < 3; ++a)
      sum += std::abs(direction[a]) * size[a];
    return sum;
  };
  view.width = extent(view.right);
  view.height = world.dimension == 1 ? 1.6 * world.spacing[0] : extent(view.up);
  view.depth = extent(view.toward);
  return view;
}

/// Names of what moves, in its colours: as many as can be read, smaller where they are many.
void add_legend(vtkRenderer& page_renderer, const WorldScene& world, const Page& page) {
  constexpr std::size_t easily = 7, most = 14;
  std::vector<std::size_t> named;
  for (std::size_t i = 0; i < world.objects.size(); ++i)
    if (world.objects[i].kind != ObjectKind::fixed)
      named.push_back(i);
  const std::size_t n = std::min(named.size(), most), n_more = named.size() - n;
  const double room = page.legend.width / std::max<double>(static_cast<double>(n), 1),
               em = 0.85 * page.text_size *
                    std::min(1.0, static_cast<double>(easily) / std::max(static_cast<double>(n), 1.0));
  for (std::size_t i = 0; i < n; ++i)
    add_text(page_renderer,
             i + 1 == n && n_more > 0 ? "and " + std::to_string(n_more + 1) + " more"
                                      : world.objects[named[i]].name,
             page.legend.left + (static_cast<double>(i) + 0.5) * room,
             page.legend.bottom + page.legend.height, em, object_colour(world, named[i]), true);
}

/// The world's border: its edges, which are a wall's.
vtkSmartPointer<vtkProp> outline_of(const WorldScene& world, double pixels_per_metre) {
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> lines;
  Vec3 size{};
  for (int a = 0; a < world.dimension; ++a)
    size[a] = world.cells[a] * world.spacing[a];
  if (world.dimension == 1)
    size[1] = 1 / pixels_per_metre; // a line, not nothing
  for (int corner = 0; corner < 8; ++corner)
    points->InsertNextPoint((corner & 1) * size[0], (corner >> 1 & 1) * size[1], (corner >> 2 & 1) * size[2]);
  for (vtkIdType corner = 0; corner < 8; ++corner)
    for (vtkIdType axis = 0; axis < 3; ++axis)
      if ((corner >> axis & 1) == 0)
        lines->InsertNextCell({corner, corner | vtkIdType{1} << axis});
  vtkNew<vtkPolyData> edges;
  edges->SetPoints(points);
  edges->SetLines(lines);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(edges);
  auto actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(0.78, 0.79, 0.82);
  actor->GetProperty()->LightingOff();
  return actor;
}

vtkSmartPointer<vtkRenderer> renderer_of(const WorldScene& world, const WorldMoment& moment, const View& view,
                                         const Page& page, const Box& box) {
  auto renderer = vtkSmartPointer<vtkRenderer>::New();
  renderer->SetBackground(0.965, 0.968, 0.975);
  for (std::size_t i = 0; i < world.objects.size(); ++i)
    for (const auto& actor : object_actors(world, i, *moment.objects[i], view, page.scale))
      renderer->AddViewProp(actor);
  if (!moment.contacts.empty())
    renderer->AddViewProp(dots(moment.contacts, 2.5 * std::max(1.0, page.width / 1000.0) / page.scale, view));
  renderer->AddViewProp(outline_of(world, page.scale));
  add_lights(*renderer);
  aim(*renderer, view, page, box);
  return renderer;
}

} // namespace

std::optional<std::string> render_world(const WorldScene& world, const std::vector<WorldPanel>& panels,
                                        const std::filesystem::path& png,
                                        const WorldPictureSettings& settings) {
  const View view = view_of(world);
  const PictureSettings page_settings{
      .title = settings.title, .width = settings.width, .largest_height = settings.largest_height};
  Page page = choose_page(view, panels.size(), page_settings, {.label = 1.8, .legend = 1.2});
  page.width += page.width % 2;
  page.height += page.height % 2;
  std::string why_not;
  const auto offscreen = OffscreenWindow::open(page.width, page.height, why_not);
  if (offscreen == nullptr)
    return why_not;
  vtkRenderWindow& window = offscreen->window();
  vtkNew<vtkRenderer> background;
  background->SetBackground(1, 1, 1);
  add_legend(*background, world, page);
  if (!settings.title.empty())
    add_text(*background, settings.title, page.width / 2.0, page.title.bottom + page.title.height,
             1.1 * page.text_size, ink, true);
  for (std::size_t i = 0; i < panels.size(); ++i)
    add_text(*background, panels[i].label, page.labels[i].left + page.labels[i].width / 2,
             page.labels[i].bottom + page.labels[i].height, page.text_size, quiet_ink, false);
  window.AddRenderer(background);
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const auto renderer = renderer_of(world, *panels[i].moment, view, page, page.drawings[i]);
    renderer->SetLayer(1);
    renderer->EraseOn();
    window.AddRenderer(renderer);
  }
  window.Render();
  save(window, png);
  return std::nullopt;
}

} // namespace maille::studies
