#include "view/seen_scene.hpp"

#include "maille/deform/world/trajectory_drives.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace maille::studies {

namespace {

/// Colours of bodies that have none, by their number: alike in lightness, apart in hue.
Rgb colour_of_body(std::size_t number) {
  constexpr std::array<Rgb, 6> colours{{{0.78f, 0.62f, 0.45f},
                                        {0.47f, 0.63f, 0.76f},
                                        {0.62f, 0.70f, 0.48f},
                                        {0.80f, 0.52f, 0.50f},
                                        {0.66f, 0.57f, 0.76f},
                                        {0.82f, 0.74f, 0.46f}}};
  return colours[number % colours.size()];
}

/// Cells around matter that come along with it.
int margin_of(const Look& look, const Specimen& body) {
  constexpr double most = 64;
  const Vec3& h = body.grid.spacing();
  const double cells = std::ceil(look.around.value_or(0) / std::min({h[0], h[1], h[2]}));
  return static_cast<int>(std::clamp(cells, 1.0, most));
}

/// A value that is as clear as a look has any: where its ends are, beyond them, so that none of the values
/// between codes is seen.
float clearest_value(const Seen& seen) {
  const auto least = std::ranges::min_element(seen.look.opacity, {}, &OpacityPoint::opacity);
  const double clear = least->opacity;
  if (seen.look.opacity.front().opacity == clear)
    return static_cast<float>(std::min(seen.look.opacity.front().value, seen.least));
  if (seen.look.opacity.back().opacity == clear)
    return static_cast<float>(std::max(seen.look.opacity.back().value, seen.largest));
  return static_cast<float>(least->value);
}

/// Grey values farther from a body than its look says take the value that is least opaque.
void hide_what_is_not_near(const Specimen& body, Seen& seen) {
  if (!seen.look.around || !std::isfinite(*seen.look.around) || seen.grey.values.empty())
    return;
  const auto lattice = render::lattice_of(body, margin_of(seen.look, body));
  const float clear = clearest_value(seen);
  const ImageInfo& info = seen.grey.info;
  std::size_t voxel = 0;
  for (int k = 0; k < info.size[2]; ++k)
    for (int j = 0; j < info.size[1]; ++j)
      for (int i = 0; i < info.size[0]; ++i, ++voxel) {
        Vec3 world = info.origin;
        const Vec3 steps{info.spacing[0] * i, info.spacing[1] * j, info.spacing[2] * k};
        for (std::size_t row = 0; row < 3; ++row)
          world[row] += std::inner_product(steps.begin(), steps.end(), info.direction[row].begin(), 0.0);
        const Vec3 at = point_in_object(seen.placement, world);
        std::int64_t cell = 0;
        bool is_near = true;
        for (std::size_t a = 3; a-- > 0;) {
          const double place = std::floor((at[a] - lattice->origin[a]) / lattice->spacing[a]);
          is_near = is_near && place >= 0 && place < lattice->cells[a];
          cell = is_near ? cell * lattice->cells[a] + static_cast<std::int64_t>(place) : 0;
        }
        if (!is_near || lattice->carries[cell] == 0)
          seen.grey.values[voxel] = clear;
      }
}

void add_body(const Specimen& body, std::optional<Seen> seen, bool is_deformable, SeenScene& to) {
  Seen of;
  if (seen)
    of = std::move(*seen);
  else
    of.look = solid_look(colour_of_body(to.objects.size()));
  render::SceneObject object;
  if (!is_deformable)
    hide_what_is_not_near(body, of);
  object.volume = render::volume_of(of, body);
  object.look = std::make_shared<Look>(of.look);
  object.paint = paint_of_look(body, of.look);
  std::shared_ptr<render::Deformation> deformation;
  if (is_deformable)
    deformation = std::make_shared<render::Deformation>(render::lattice_of(body, margin_of(of.look, body)));
  object.deformation = deformation;
  to.objects.push_back(std::move(object));
  to.deformations.push_back(std::move(deformation));
}

} // namespace

std::shared_ptr<const render::Paint> paint_of_look(const Specimen& body, const Look& look) {
  if (!look.picture.empty())
    return paint_of_picture(body, look);
  return look.label_colours.empty() || body.label.empty() ? nullptr : paint_of_labels(body, look);
}

std::int64_t SeenScene::bytes() const {
  std::int64_t sum = 0;
  for (const render::SceneObject& object : objects)
    sum += object.volume->bytes() + (object.paint ? object.paint->bytes() : 0) +
           (object.deformation ? object.deformation->bytes() : 0);
  return sum;
}

SeenScene seen_scene(const Scene& scene, const std::filesystem::path& file, bool is_deformed) {
  return seen_scene(scene, read_looks(file), is_deformed);
}

SeenScene seen_scene(const Scene& scene, std::vector<std::optional<Seen>> looks, bool is_deformed) {
  SeenScene seen{scene.name, scene.title, {}, {}};
  std::optional<Seen> look = looks.empty() ? std::nullopt : std::move(looks.front());
  const Placement& placement = scene.specimen.placement;
  if (look && scene.specimen.shape == "image")
    look->placement = placement;
  add_body(scene.specimen, std::move(look), is_deformed, seen);
  seen.objects[0].pose = {placement.direction, placement.origin};
  return seen;
}

SeenScene seen_world(const WorldScene& world, const std::filesystem::path& file) {
  SeenScene seen{world.name, world.title, {}, {}};
  auto looks = read_looks(file);
  looks.resize(world.objects.size());
  for (std::size_t o = 0; o < world.objects.size(); ++o)
    add_body(world.objects[o].scene.specimen, std::move(looks[o]),
             world.objects[o].kind == ObjectKind::deformable, seen);
  return seen;
}

void follow(const deform::World& world, SeenScene& seen) {
  for (std::size_t o = 0; o < seen.objects.size(); ++o) {
    const int object = static_cast<int>(o);
    const deform::Pose pose = seen.deformations[o] ? world.pose(object) : deform::frame_of(world, o);
    for (int row = 0; row < 3; ++row) {
      const std::size_t r = row;
      seen.objects[o].pose.position[r] = pose.position[row];
      for (int column = 0; column < 3; ++column)
        seen.objects[o].pose.rotation[r][column] = pose.rotation(row, column);
    }
    if (seen.deformations[o])
      carry_along(world.scene().objects[o].scene.specimen, world.displacement(object), *seen.deformations[o]);
  }
}

void follow(const Scene& scene, const Displacement& displacement, SeenScene& seen) {
  carry_along(scene.specimen, displacement, *seen.deformations.at(0));
}

} // namespace maille::studies
