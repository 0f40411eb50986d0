#pragma once
/// The force of a load on a face of a cell, in the object's frame.
///
/// A traction is a dead load: its force refers to the area at rest. A pressure at finite strain stays normal
/// to its face, on the deformed area. The vector area is half the cross product of the face's diagonals (in
/// 2D its edge, rotated by a right angle), so the force equals the one in `coupled`. It acts at the mean of
/// the face's corners.
///
/// Exact: for flat faces, and for the resultant on any closed surface. Cost  O(1).
/// Source  Bonet and Wood 2008, Nonlinear Continuum Mechanics, section 8.5 (pressure as a boundary term)

#include "maille/scene/block_frames.hpp"

#include <Eigen/Geometry>

namespace maille {

/// True if the answer is at finite strain: `limits`, `relaxed` and `sweep` ignore `strain`.
inline bool is_of_finite_strain(const Scene& scene, const Answer& answer) {
  return in_blocks(scene) &&
         (answer.method == "coupled" || answer.method.starts_with("fem_") || answer.method == "calculix");
}

/// @param load on a cell of the scene's grid; @param answer with a displacement
/// @return force [N], in 2D [N/m]. In 1D faces do not rotate
inline Vec3 force_on_face(const Scene& scene, const Answer& answer, const FaceLoad& load) {
  const Grid& grid = scene.specimen.grid;
  const int d = grid.dimension(), a = load.axis, b = (a + 1) % d, c = (a + 2) % 3;
  const auto corner = [&](int along_b, int along_c) {
    const int bits = (load.upper ? 1 << a : 0) | along_b << b | along_c << c;
    const Index3 at = grid.node_at(grid.corner(grid.cell_at(load.cell), bits));
    Eigen::Vector3d x = Eigen::Vector3d::Zero();
    for (int k = 0; k < d; ++k)
      x[k] = grid.spacing()[k] * at[k] + answer.displacement(k, grid.node(at));
    return x;
  };
  Eigen::Vector3d force;
  if (load.follows && is_of_finite_strain(scene, answer)) {
    const Eigen::Vector3d across =
        d == 3 ? (corner(0, 1) - corner(1, 0)).eval() : Eigen::Vector3d(0, 0, a == 0 ? 2 : -2);
    force = load.traction[a] / 2 * (corner(1, d - 2) - corner(0, 0)).cross(across);
  } else {
    force = {load.traction[0], load.traction[1], load.traction[2]};
    for (int k = 0; k < d; ++k)
      force *= k == a ? 1 : grid.spacing()[k];
  }
  return {force[0], force[1], force[2]};
}

} // namespace maille
