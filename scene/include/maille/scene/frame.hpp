#pragma once
/// The object's frame: limits and small strains are measured in it, and it turns with the body.
///
/// Where moves turn a free body, the frame is the rotation nearest to the moved nodes (Kabsch). Methods
/// solve in the turned frame and rotate the answer back. A body that is held stays in the world's frame.

#include "maille/scene/scene.hpp"

#include <Eigen/Core>

#include <span>

namespace maille {

class Displacement;

/// How a body has been carried along as a whole: what was at x is at to + rotation (x - from + w), with w the
/// displacement within the body. Not turned: w is the displacement itself.
struct Frame {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Vec3 from{}, to{}; ///< [m]; of no account where the frame is not turned
  bool is_turned = false;

  /// Displacement within the body of a point that rests at x and is displaced by u [m].
  Vec3 in_object(const Vec3& x, const Vec3& u) const;
  /// Displacement of a point that rests at x and is displaced by w within the body [m].
  Vec3 in_world(const Vec3& x, const Vec3& w) const;
  /// Angle of the turn [rad], 0 to pi.
  double angle() const;
};

/// The rotation that takes points at rest nearest to where they are displaced, in the sum of squares.
///
/// A frame that is turned goes along with the points' middle; one that is not stays where it is, so the
/// smallest turn makes another request than a shift alone. Not turned where all points are displaced by the
/// same, where the rotation is no larger than rounding can make it, or where none is the nearest (all points
/// in one place, or reflected symmetrically). Points on a line take the smallest turn that takes the line
/// along. Otherwise a rotation Q of all displaced points turns the frame by Q; translations and symmetric
/// stretches keep their bits.
///
/// @param dimension 1: never turned; 2: in the plane of x and y; 3
/// @param rest, displacement one each a point, finite [m]
/// Source  Kabsch 1976 (Acta Crystallographica A32); Arun, Huang, Blostein 1987, with the determinant's sign
///         of Umeyama 1991
Frame fit_frame(int dimension, std::span<const Vec3> rest, std::span<const Vec3> displacement);

/// The frame of a scene's body: fitted to its moved nodes, if they say how the body turns. That is so where
/// no hold or spring ties the body to the world and every moved node has all of its components
/// prescribed; else not turned.
/// Cost  O(prescribed)
Frame object_frame(const Scene& scene);

/// Prescribed components as displacements within the body; those of the scene where the frame is not turned.
/// @pre frame is object_frame(scene)
std::vector<Prescribed> prescribed_in_object(const Scene& scene, const Frame& frame);
/// The same question asked within the body: moves and loads in the frame's directions, limits as in `scene`.
Scene in_object(const Scene& scene, const Frame& frame);

/// Displacements of nodes of the body from one frame to the other, in place. O(nodes)
void to_object(const Scene& scene, const Frame& frame, Displacement& displacement);
void to_world(const Scene& scene, const Frame& frame, Displacement& displacement);

} // namespace maille
