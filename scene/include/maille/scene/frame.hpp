#pragma once
/// The object's frame, which rotates with the body: limits and small strains are measured in it.
///
/// If moves rotate a free body, the frame is the rotation that fits the moved nodes best (Kabsch). Methods
/// solve in the rotated frame and rotate the answer back. A body that is held stays in the world's frame.

#include "maille/scene/scene.hpp"

#include <Eigen/Core>

#include <span>

namespace maille {

class Displacement;

/// Rigid motion of a body as a whole: a point at x moves to to + rotation (x - from + w), with w the
/// displacement within the body. Not turned: w is the displacement itself.
struct Frame {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Vec3 from{}, to{}; ///< [m]; ignored if the frame is not turned
  bool is_turned = false;

  /// Displacement within the body of a point that rests at x and is displaced by u [m].
  Vec3 in_object(const Vec3& x, const Vec3& u) const;
  /// Displacement of a point that rests at x and is displaced by w within the body [m].
  Vec3 in_world(const Vec3& x, const Vec3& w) const;
  /// Angle of the rotation [rad], 0 to pi.
  double angle() const;
};

/// The rotation that maps points at rest to their displaced places best, in the least-squares sense.
///
/// A rotated frame moves with the centroid of the points; one that is not rotated stays in place, so a tiny
/// rotation is a different request than a pure shift. Not rotated: if all points have the same displacement,
/// if the rotation is at rounding level, or if no rotation is nearest (all points in one place, or reflected
/// symmetrically). Points on a line take the smallest rotation that maps the line. Otherwise a rotation Q of
/// all displaced points rotates the frame by Q; translations and symmetric stretches keep their bits.
///
/// @param dimension 1: never rotated; 2: in the plane of x and y; 3
/// @param rest, displacement one entry per point, finite [m]
/// Source  Kabsch 1976 (Acta Crystallographica A32); Arun, Huang, Blostein 1987, with the determinant's sign
///         of Umeyama 1991
Frame fit_frame(int dimension, std::span<const Vec3> rest, std::span<const Vec3> displacement);

/// The frame of a scene's body: fitted to its moved nodes if they determine the rotation, which requires that
/// no hold or spring ties the body to the world and that every moved node has all components prescribed; else
/// not turned.
/// Cost  O(prescribed)
Frame object_frame(const Scene& scene);

/// Prescribed components as displacements within the body; those of the scene if the frame is not turned.
/// @pre frame is object_frame(scene)
std::vector<Prescribed> prescribed_in_object(const Scene& scene, const Frame& frame);
/// The same scene within the body: moves and loads in the frame's directions, limits as in `scene`.
Scene in_object(const Scene& scene, const Frame& frame);

/// Transforms displacements of nodes from one frame to the other, in place. O(nodes)
void to_object(const Scene& scene, const Frame& frame, Displacement& displacement);
void to_world(const Scene& scene, const Frame& frame, Displacement& displacement);

} // namespace maille
