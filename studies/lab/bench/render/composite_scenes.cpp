// Objects that are in each other's way, against the plain caster.

#include "bench/render/render.hpp"

#include "maille/render/renderer.hpp"
#include "maille/scene/world/world_scene.hpp"
#include "rivals/plain_caster.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace maille::lab {

namespace {

using namespace render;
using Values = std::function<double(const Vec3&)>;

constexpr double voxel = 1e-3;

Look ramp(const Rgb& colour, double opacity) {
  Look look;
  look.colours = {{0, {1, 1, 1}}, {1, colour}};
  look.opacity = {{0.3, 0}, {0.8, opacity}};
  return look;
}

/// A cube of voxels about the origin.
SceneObject cube(int n, const Look& look, const Values& value) {
  VoxelGrid grid;
  grid.size = {n, n, n};
  grid.spacing = {voxel, voxel, voxel};
  const double corner = -0.5 * voxel * (n - 1);
  grid.origin = {corner, corner, corner};
  std::vector<float> values;
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i)
        values.push_back(
            static_cast<float>(value({corner + voxel * i, corner + voxel * j, corner + voxel * k})));
  SceneObject object;
  object.volume = std::make_shared<Volume>(grid, values, 0, 1);
  object.look = std::make_shared<Look>(look);
  return object;
}

double matter(double outside) {
  return std::clamp(0.5 - outside / (2 * voxel), 0.0, 1.0);
}

std::vector<SceneObject> interlocked_rings() {
  const auto ring = [](const Vec3& x) {
    return matter(std::hypot(std::hypot(x[0], x[1]) - 8e-3, x[2]) - 2.5e-3);
  };
  std::vector<SceneObject> rings{cube(28, ramp({0.9f, 0.4f, 0.2f}, 0.9), ring),
                                 cube(28, ramp({0.2f, 0.5f, 0.9f}, 0.3), ring)};
  rings[1].pose = {{{{1, 0, 0}, {0, 0, -1}, {0, 1, 0}}}, {8e-3, 0, 0}};
  return rings;
}

std::vector<SceneObject> nut_on_bolt() {
  const WorldScene world = parse_world_scene(R"(
units = "mm"
[world]
cells = [40, 40, 40]
spacing = 1
[[object]]
name = "bolt"
kind = "fixed"
shape = "bolt"
cells = [20, 20, 26]
thread = { radius = 6, depth = 2, pitch = 6 }
head = 5
[[object]]
name = "nut"
kind = "rigid"
shape = "nut"
cells = [20, 20, 8]
thread = { radius = 6, depth = 2, pitch = 6, play = 0.5 }
position = [0, 0, 10]
)");
  std::vector<SceneObject> objects;
  for (const WorldObject& of : world.objects) {
    SceneObject object;
    object.volume = volume_of_matter(of.scene.specimen);
    object.look =
        std::make_shared<Look>(ramp(objects.empty() ? Rgb{0.7f, 0.7f, 0.75f} : Rgb{0.9f, 0.7f, 0.3f}, 0.9));
    object.pose.position = {of.position[0] - 10e-3, of.position[1] - 10e-3, of.position[2] - 12e-3};
    objects.push_back(std::move(object));
  }
  return objects;
}

std::vector<SceneObject> pressed_bodies() {
  std::vector<SceneObject> objects;
  for (const double side : {-1.0, 1.0}) {
    SceneObject object =
        cube(18, ramp(side < 0 ? Rgb{0.8f, 0.3f, 0.3f} : Rgb{0.3f, 0.6f, 0.4f}, side < 0 ? 0.3 : 0.8),
             [](const Vec3& x) {
               return matter(std::max({std::abs(x[0]), std::abs(x[1]), std::abs(x[2])}) - 6e-3);
             });
    auto lattice = std::make_shared<Lattice>();
    lattice->cells = {9, 9, 9};
    lattice->spacing = {2 * voxel, 2 * voxel, 2 * voxel};
    lattice->origin = {-9e-3, -9e-3, -9e-3};
    auto deformation = std::make_shared<Deformation>(lattice);
    std::vector<Vec3> positions;
    for (std::int64_t node = 0; node < lattice->n_nodes(); ++node) {
      const Vec3 x = deformation->position(node);
      // Both faces that touch are bent alike.
      positions.push_back(
          {x[0] + side * 5.5e-3 + 30 * x[1] * x[1], x[1] * (1 + 10 * side * x[0]), x[2] + 0.3 * x[1]});
    }
    deformation->set_positions(positions);
    object.deformation = deformation;
    objects.push_back(std::move(object));
  }
  return objects;
}

std::vector<SceneObject> c_around_a_rod() {
  return {cube(26, ramp({0.9f, 0.4f, 0.2f}, 0.5),
               [](const Vec3& x) {
                 const double wall = std::abs(std::hypot(x[0], x[1]) - 7e-3) - 2e-3;
                 const double gap = 3e-3 - std::hypot(x[0] - 7e-3, x[1]);
                 return matter(std::max({wall, gap, std::abs(x[2]) - 6e-3}));
               }),
          cube(26, ramp({0.3f, 0.8f, 0.3f}, 0.9), [](const Vec3& x) {
            return matter(std::max(std::hypot(x[0], x[1]) - 4.5e-3, std::abs(x[2]) - 10e-3));
          })};
}

rivals::PlainObject plain(const SceneObject& object) {
  rivals::PlainObject to;
  const Volume& volume = *object.volume;
  to.size = volume.grid().size;
  to.spacing = volume.grid().spacing;
  to.origin = volume.grid().origin;
  for (std::int64_t v = 0; v < volume.grid().n_voxels(); ++v)
    to.values.push_back(volume.value(v)); // as they are kept: merging is what is measured
  to.low = volume.low();
  to.high = volume.high();
  to.look = *object.look;
  to.unit_distance = voxel;
  to.rotation = object.pose.rotation;
  to.position = object.pose.position;
  if (object.deformation) {
    const Lattice& lattice = object.deformation->lattice();
    to.cells = lattice.cells;
    to.lattice_origin = lattice.origin;
    to.lattice_spacing = lattice.spacing;
    for (std::int64_t node = 0; node < lattice.n_nodes(); ++node)
      to.nodes.push_back(object.deformation->position(node));
  }
  return to;
}

double largest_difference(const std::vector<SceneObject>& objects, const View& view, Renderer& renderer) {
  const Picture& picture = renderer.render(objects, view);
  std::vector<rivals::PlainObject> all;
  std::ranges::transform(objects, std::back_inserter(all), plain);
  const Vec3 ahead = view.camera.axes()[2];
  const rivals::PlainView of{ahead, {-ahead[0], -ahead[1], -ahead[2]}, voxel / view.samples_per_voxel, 0.2};
  double largest = 0;
  for (int y = 0; y < view.height; ++y)
    for (int x = 0; x < view.width; ++x) {
      const Ray ray = view.camera.ray(view.width, view.height, x, y);
      const auto expected = rivals::cast_plainly(all, of, ray.origin, ray.direction);
      for (std::size_t c = 0; c < 4; ++c)
        largest = std::max(
            largest, 255 * std::abs(expected[c] - static_cast<double>(picture.rgba[picture.pixel(x, y)][c])));
    }
  return largest;
}

} // namespace

double composite_error(bool quick) {
  double largest = 0;
  Renderer renderer;
  for (const auto& objects : {interlocked_rings(), nut_on_bolt(), pressed_bodies(), c_around_a_rod()})
    for (const Vec3& eye : {Vec3{0.02, 0.03, 0.11}, Vec3{-0.09, 0.04, 0.05}, Vec3{0.03, -0.11, 0.02}}) {
      View view;
      view.camera.position = eye;
      view.camera.view_up = {0.1, 0.2, 0.9};
      view.camera.view_angle = 25;
      view.width = view.height = quick ? 16 : 40;
      view.samples_per_voxel = quick ? 2 : 8;
      largest = std::max(largest, largest_difference(objects, view, renderer));
    }
  return largest;
}

double slab_error() {
  double largest = 0;
  for (const double opacity : {0.002, 0.02, 0.1}) {
    Look look;
    look.colours = {{0, {1, 1, 1}}};
    look.opacity = {{0, opacity}};
    look.shading.on = false;
    const SceneObject slab = cube(33, look, [](const Vec3&) { return 1.0; });
    View view;
    view.camera.position = {0, 0, 0.1};
    view.camera.parallel = true;
    view.camera.parallel_scale = 1e-3;
    view.width = view.height = 3;
    Renderer renderer;
    const double found = renderer.render(std::span(&slab, 1), view).rgba[4][3];
    largest = std::max(largest, std::abs(found - (1 - std::pow(1 - opacity, 32))));
  }
  return largest;
}

} // namespace maille::lab
