#include "picture/world_picture.hpp"

#include "body_actors.hpp"
#include "drawing.hpp"

#include <algorithm>
#include <iterator>

namespace maille::studies {
namespace {

/// The corners of the world, whatever is in it.
std::vector<Vec3> corners_of(const WorldScene& world) {
  Vec3 size{};
  for (int a = 0; a < world.dimension; ++a)
    size[a] = world.cells[a] * world.spacing[a];
  std::vector<Vec3> corners;
  for (int corner = 0; corner < 8; ++corner)
    corners.push_back({(corner & 1) * size[0], (corner >> 1 & 1) * size[1], (corner >> 2 & 1) * size[2]});
  return corners;
}

View view_of(const WorldScene& world) {
  View view = world.dimension == 3 ? looking({1, 0, 0}, {0, 0, 1}, 28, 24) : View{};
  SeenBox seen(view);
  std::ranges::for_each(corners_of(world), [&](const Vec3& corner) { seen.include(corner); });
  seen.fit(view);
  if (world.dimension == 1)
    view.height = 1.6 * world.spacing[0];
  return view;
}

/// Names of moving objects in their colours: as many as are legible, smaller if there are many.
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

/// Edges of the world's border, which acts as a wall.
vtkSmartPointer<vtkProp> outline_of(const WorldScene& world, double pixels_per_metre) {
  std::vector<Vec3> corners = corners_of(world);
  std::vector<Shape> edges;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    if (world.dimension == 1 && (corner >> 1 & 1) == 1)
      corners[corner][1] = 1 / pixels_per_metre;
    for (std::size_t axis = 0; axis < 3; ++axis)
      if ((corner >> axis & 1) == 1)
        edges.push_back({corners[corner ^ std::size_t{1} << axis], corners[corner]});
  }
  return flat_actor(data_of(edges, true), {0.78, 0.79, 0.82});
}

/// Dots where objects touch, in front of everything.
vtkSmartPointer<vtkProp> dots(const std::vector<Vec3>& points, double radius, const View& view) {
  std::vector<Shape> discs;
  for (const Vec3& point : points)
    discs.push_back(disc(point, radius, view));
  const auto actor = flat_actor(data_of(discs), {0.85, 0.1, 0.15});
  bring_forward(*actor, view, view.depth + 2 * radius);
  return actor;
}

Props props_of(const WorldScene& world, const WorldMoment& moment, const View& view, const Page& page) {
  Props props;
  for (std::size_t i = 0; i < world.objects.size(); ++i)
    std::ranges::move(object_actors(world, i, *moment.objects[i], view, page.scale),
                      std::back_inserter(props));
  if (!moment.contacts.empty())
    props.push_back(dots(moment.contacts, 2.5 * std::max(1.0, page.width / 1000.0) / page.scale, view));
  props.push_back(outline_of(world, page.scale));
  return props;
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
  const auto sheet = Sheet::open(page, view, why_not);
  if (sheet == nullptr)
    return why_not;
  add_legend(sheet->paper(), world, page);
  sheet->add_title(settings.title);
  for (std::size_t i = 0; i < panels.size(); ++i) {
    sheet->write_under(i, panels[i].label, quiet_ink, false);
    sheet->draw(i, props_of(world, *panels[i].moment, view, page), Vec3{0.965, 0.968, 0.975});
  }
  sheet->save(png);
  return std::nullopt;
}

} // namespace maille::studies
