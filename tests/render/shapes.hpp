#pragma once
/// Objects whose values are functions of place, and the same objects for the oracle.

#include "maille/render/renderer.hpp"
#include "rivals/plain_caster.hpp"
#include "support/kit.hpp"

namespace maille::render::test {

/// A cube of n^3 voxels about the origin, 1 mm apart, with values of a function of place [m].
inline SceneObject cube(int n, const std::function<double(const Vec3&)>& value, const Look& look) {
  VoxelGrid grid;
  grid.size = {n, n, n};
  grid.spacing = {1e-3, 1e-3, 1e-3};
  const double corner = -0.5e-3 * (n - 1);
  grid.origin = {corner, corner, corner};
  std::vector<float> values;
  for (const auto& [i, j, k] : maille::test::all_below({n, n, n}))
    values.push_back(float(value({corner + 1e-3 * i, corner + 1e-3 * j, corner + 1e-3 * k})));
  SceneObject object;
  object.volume = std::make_shared<Volume>(grid, values, 0, 1);
  object.look = std::make_shared<Look>(look);
  return object;
}

/// A ring in the plane of x and y: 1 inside, 0 outside, a slope of two voxels between.
inline std::function<double(const Vec3&)> ring(double radius, double thickness) {
  return [=](const Vec3& x) {
    const double off = std::hypot(std::hypot(x[0], x[1]) - radius, x[2]) - thickness;
    return std::clamp(0.5 - off / 2e-3, 0.0, 1.0);
  };
}

inline Look half_clear(const Rgb& colour, double opacity) {
  Look look;
  look.colours = {{0, {1, 1, 1}}, {1, colour}};
  look.opacity = {{0.3, 0}, {0.8, opacity}};
  return look;
}

inline Pose turned(const Vec3& position, double about_x, double about_y = 0) {
  const double c = std::cos(about_x), s = std::sin(about_x), d = std::cos(about_y), e = std::sin(about_y);
  Pose pose;
  pose.position = position;
  pose.rotation = {{{d, e * s, e * c}, {0, c, -s}, {-e, d * s, d * c}}};
  return pose;
}

/// Cells of 2 mm around the object's voxels, bent and twisted.
inline std::shared_ptr<Deformation> bent(const SceneObject& object, double strength) {
  const VoxelGrid& grid = object.volume->grid();
  auto lattice = std::make_shared<Lattice>();
  for (std::size_t a = 0; a < 3; ++a) {
    lattice->cells[a] = grid.size[a] / 2 + 1;
    lattice->spacing[a] = 2e-3;
    lattice->origin[a] = grid.origin[a] - 0.6e-3;
  }
  auto deformation = std::make_shared<Deformation>(lattice);
  std::vector<Vec3> positions;
  for (std::int64_t node = 0; node < lattice->n_nodes(); ++node) {
    const Vec3 x = deformation->position(node);
    const double angle = strength * 40 * x[2];
    positions.push_back({x[0] * std::cos(angle) - x[1] * std::sin(angle) + strength * 30 * x[2] * x[2],
                         x[0] * std::sin(angle) + x[1] * std::cos(angle), x[2] * (1 + 10 * strength * x[0])});
  }
  deformation->set_positions(positions);
  return deformation;
}

/// What the oracle is told of an object: the values that are kept, not those that were given.
inline lab::rivals::PlainObject plain(const SceneObject& object) {
  lab::rivals::PlainObject to;
  const Volume& volume = *object.volume;
  to.size = volume.grid().size;
  to.spacing = volume.grid().spacing;
  to.origin = volume.grid().origin;
  for (std::int64_t v = 0; v < volume.grid().n_voxels(); ++v)
    to.values.push_back(volume.value(v));
  to.low = volume.low();
  to.high = volume.high();
  to.smooth = smoothed(to);
  to.look = *object.look;
  to.unit_distance = std::min({to.spacing[0], to.spacing[1], to.spacing[2]});
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

/// The largest difference of any channel between a picture and the oracle's, in 255ths.
/// @param every  pixels of that many rows and columns are compared
inline double difference(const Picture& picture, const std::vector<SceneObject>& objects, const View& view,
                         int every = 1) {
  std::vector<lab::rivals::PlainObject> all;
  for (const SceneObject& object : objects)
    all.push_back(plain(object));
  const auto [right, up, ahead] = view.camera.axes();
  lab::rivals::PlainView of;
  of.ahead = ahead;
  const double length = std::hypot(view.light[0], view.light[1], view.light[2]);
  for (std::size_t a = 0; a < 3; ++a)
    of.light[a] = (view.light[0] * right[a] + view.light[1] * up[a] - view.light[2] * ahead[a]) / length;
  of.step = 1e-3 / view.samples_per_voxel;
  of.farthest = 0.3;
  for (const ClipPlane& clip : view.clips)
    of.clips.push_back({clip.point, clip.normal});
  double largest = 0;
  for (int y = 0; y < view.height; y += every)
    for (int x = 0; x < view.width; x += every) {
      const Ray ray = view.camera.ray(view.width, view.height, x, y);
      const auto expected = lab::rivals::cast_plainly(all, of, ray.origin, ray.direction);
      for (std::size_t c = 0; c < 4; ++c)
        largest =
            std::max(largest, 255 * std::abs(expected[c] - double(picture.rgba[picture.pixel(x, y)][c])));
    }
  return largest;
}

inline View view_from(const Vec3& position, int pixels, double samples = 2) {
  View view;
  view.camera.position = position;
  view.camera.view_up = {0.1, 0.9, 0.2};
  view.camera.view_angle = 25;
  view.width = pixels;
  view.height = pixels;
  view.samples_per_voxel = samples;
  view.light = {-0.3, 0.5, 1};
  return view;
}

} // namespace maille::render::test
