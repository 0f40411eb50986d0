#pragma once
/// Bodies and tools for tests of the probe.

#include "maille/deform/probe/touch.hpp"

#include "support/bodies/scenes.hpp"

#include <Eigen/Geometry>

#include <cmath>

namespace maille::test {

/// A box with a bore through it and a notch, so that there are edges and corners of all kinds, its lower end
/// held.
inline Scene carved_body(const Index3& cells, const Vec3& spacing) {
  Scene scene = box_scene(3, cells, spacing);
  scene.specimen.material_id.assign(static_cast<std::size_t>(scene.specimen.grid.n_cells()), 0);
  for (std::int64_t cell = 0; cell < scene.specimen.grid.n_cells(); ++cell) {
    const Index3 at = scene.specimen.grid.cell_at(cell);
    const bool is_bore = at[0] == cells[0] / 2 && at[1] == cells[1] / 2;
    const bool is_notch = at[2] >= cells[2] - 2 && at[1] <= 1;
    if (is_bore || is_notch)
      scene.specimen.material_id[static_cast<std::size_t>(cell)] = no_material;
  }
  hold_face(scene, 2, false);
  return scene;
}

/// A block that stands on a table without friction: nothing hinders it from growing wide.
inline Scene free_block(const Index3& cells) {
  Scene scene = box_scene(3, cells);
  prescribe_face(scene, 2, false, 2, 0, true);
  const Grid& grid = scene.specimen.grid;
  scene.prescribed.push_back({grid.node({0, 0, 0}), 0, 0, true});
  scene.prescribed.push_back({grid.node({0, 0, 0}), 1, 0, true});
  scene.prescribed.push_back({grid.node({0, cells[1], 0}), 0, 0, true}); // against turning
  sort_prescribed(scene);
  scene.relaxation.tolerance = 1e-8;
  return scene;
}

/// A smooth bend and swelling, by about a cell.
inline Displacement bent(const Scene& scene, double amount) {
  Displacement displacement(scene.specimen.grid);
  const Vec3& h = scene.specimen.grid.spacing();
  for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node) {
    const Index3 at = scene.specimen.grid.node_at(node);
    displacement(0, node) = amount * h[0] * std::sin(0.5 * at[2]);
    displacement(1, node) = amount * h[1] * std::sin(0.4 * at[0] + 0.3 * at[2]);
    displacement(2, node) = amount * h[2] * std::cos(0.6 * at[1]);
  }
  return displacement;
}

inline deform::Pose turned_pose(double angle, const Eigen::Vector3d& axis, const Eigen::Vector3d& position) {
  deform::Pose pose;
  pose.rotation = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
  pose.position = position;
  return pose;
}

} // namespace maille::test
