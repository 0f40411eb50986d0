#pragma once
/// The camera of a picture, with ParaView's conventions, and clip planes.

#include "maille/base/grid.hpp"

#include <array>
#include <vector>

namespace maille::render {

/// A ray of sight; points on it are origin + t direction, t >= 0 [m].
struct Ray {
  Vec3 origin{};
  Vec3 direction{0, 0, -1}; ///< of length 1
};

/// ParaView's camera: the same five numbers give the same picture. Lengths in metres, in the world.
struct Camera {
  Vec3 position{0, 0, 1};
  Vec3 focal_point{0, 0, 0};
  Vec3 view_up{0, 1, 0};     ///< not parallel to the line of sight
  double view_angle = 30;    ///< of the picture's height [deg], 0 to 180
  bool parallel = false;     ///< orthographic: rays from the plane through `position`
  double parallel_scale = 1; ///< half of the picture's height if parallel [m]
  friend bool operator==(const Camera&, const Camera&) = default;

  /// Unit vectors to the right, up and ahead.
  std::array<Vec3, 3> axes() const;
  /// Half of the picture's height: in metres if parallel, else at a distance of 1 m from the eye.
  double half_height() const;
  /// Ray through the centre of a pixel; x from the left, y from the top. Fractions: between centres.
  Ray ray(int width, int height, double x, double y) const;
  /// Projects a point to the picture: x, y in pixels as in `ray`, and distance ahead of the eye [m].
  Vec3 project(int width, int height, const Vec3& point) const;
  /// Rotated about the focal point: azimuth about view_up, elevation about the axis to the right [deg].
  Camera turned(double azimuth, double elevation) const;
  /// Moved nearer (factor > 1) or farther (< 1).
  Camera zoomed(double factor) const;
};

/// A camera that shows the whole box between two corners from `direction` (it looks along -direction), as
/// ParaView's "reset camera" places it. @param aspect width over height
Camera seeing(const Vec3& low, const Vec3& high, const Vec3& direction, const Vec3& view_up,
              double aspect = 1, bool parallel = false);

/// Removes all on the side of `point` opposite to `normal`.
struct ClipPlane {
  Vec3 point{};
  Vec3 normal{0, 0, 1};
  friend bool operator==(const ClipPlane&, const ClipPlane&) = default;
};

/// Settings common to all objects of a picture.
struct View {
  Camera camera;
  int width = 512, height = 512; ///< [pixels], 1 to 16384
  std::vector<ClipPlane> clips;  ///< in the world, of all objects
  double samples_per_voxel = 1;  ///< along rays, > 0
  /// Direction towards the light, in the camera's axes (right, up, towards the eye); of any length.
  Vec3 light{0, 0, 1};
  double depth_cue = 0; ///< 0 to 1: darkening of the farthest point
  friend bool operator==(const View&, const View&) = default;
};

} // namespace maille::render
