#pragma once
/// Bodies of labels in an image, for tests of what carries images along.

#include "maille/scene/scene_builder.hpp"
#include "maille/scene/warp/warp.hpp"

#include <cmath>
#include <functional>
#include <random>

namespace maille::test {

/// An image of labels and the scene whose body it is.
struct ImagedBody {
  Image labels;
  Scene scene;
  Displacement u;
  std::vector<DeformedBody> bodies() const { return {{&scene.specimen, &u}}; }
};

inline ImageInfo grid_of(const Index3& size, const Vec3& spacing, const Vec3& origin = {},
                         const std::array<Vec3, 3>& direction = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}) {
  ImageInfo info;
  info.size = size;
  info.spacing = spacing;
  info.origin = origin;
  info.direction = direction;
  info.world = WorldAxes::ras;
  return info;
}

/// An oblique grid whose axes are left-handed.
inline ImageInfo oblique_grid(const Index3& size, const Vec3& spacing) {
  const double c = std::cos(0.35), s = std::sin(0.35);
  return grid_of(size, spacing, {0.01, -0.02, 0.005}, {{{-c, -s, 0}, {-s, c, 0}, {0, 0, 1}}});
}

/// @param label_at of every voxel; 0: no matter
inline ImagedBody imaged_body(const ImageInfo& grid, const std::function<int(int, int, int)>& label_at) {
  ImagedBody made;
  made.labels.info = grid;
  std::vector<std::int32_t> values;
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i)
        values.push_back(label_at(i, j, k));
  made.labels.values.assign(values.begin(), values.end());
  made.scene = SceneBuilder()
                   .labels(values, ArrayLayout::x_fastest(grid.size),
                           affine_of(grid.spacing, grid.origin, grid.direction))
                   .material("muscle/soleus")
                   .hold("x-")
                   .build();
  made.u = Displacement(made.scene.specimen.grid);
  return made;
}

/// Displaces nodes as `by` says of where they rest, object's frame [m].
inline void displace(ImagedBody& body, const std::function<Vec3(const Vec3&)>& by) {
  const Specimen& specimen = body.scene.specimen;
  for (std::int64_t node = 0; node < specimen.grid.n_nodes(); ++node) {
    const Vec3 u = by(specimen.position(specimen.grid.node_at(node)));
    for (int a = 0; a < 3; ++a)
      body.u(a, node) = u[static_cast<std::size_t>(a)];
  }
}

/// Displaces every node by up to `part` of a spacing along each axis.
inline void shake(ImagedBody& body, double part, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-part, part);
  for (std::int64_t node = 0; node < body.scene.specimen.grid.n_nodes(); ++node)
    for (int a = 0; a < 3; ++a)
      body.u(a, node) += uniform(random) * body.scene.specimen.grid.spacing()[static_cast<std::size_t>(a)];
}

/// Where a voxel's index is in the object's frame, and back; written out for itself. [m]
inline Vec3 place_of(const ImagedBody& body, const Vec3& index) {
  const ImageInfo& grid = body.labels.info;
  Vec3 world = grid.origin;
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t a = 0; a < 3; ++a)
      world[r] += grid.direction[r][a] * grid.spacing[a] * index[a];
  return point_in_object(body.scene.specimen.placement, world);
}
inline Vec3 index_of(const ImagedBody& body, const Vec3& place) {
  const ImageInfo& grid = body.labels.info;
  const Vec3 world = point_in_world(body.scene.specimen.placement, place);
  Vec3 index{};
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t r = 0; r < 3; ++r)
      index[a] += grid.direction[r][a] * (world[r] - grid.origin[r]) / grid.spacing[a];
  return index;
}

} // namespace maille::test
