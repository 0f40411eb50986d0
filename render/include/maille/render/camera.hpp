#pragma once
/// Where a picture is taken from, as ParaView has it, and what is cut away.

#include "maille/base/grid.hpp"

#include <array>
#include <vector>

namespace maille::render {

/// A ray of sight; points on it are origin + t direction, t >= 0 [m].
struct Ray {
  Vec3 origin{};
  Vec3 direction{0, 0, -1}; ///< of length 1
};

/// ParaView's camera: the same five numbers give the same picture there. Lengths in metres, in the world.
struct Camera {
  Vec3 position{0, 0, 1};
  Vec3 focal_point{0, 0, 0};
  Vec3 view_up{0, 1, 0};     ///< any that is not along the line of sight
  double view_angle = 30;    ///< of the picture's height [deg], 0 to 180
  bool parallel = false;     ///< orthographic: rays from the plane through `position`
  double parallel_scale = 1; ///< half of the picture's height where parallel [m]
  friend bool operator==(const Camera&, const Camera&) = default;

  /// Unit vectors to the right, up and ahead.
  std::array<Vec3, 3> axes() const;
  /// Half of the picture's height: in metres where parallel, else 1 m ahead of the eye.
  double half_height() const;
  /// Through the middle of a pixel; x from the left, y from the top. Fractions are points between.
  Ray ray(int width, int height, double x, double y) const;
  /// Where a point is on the picture: x, y in pixels as of `ray`, and how far ahead of the eye [m].
  Vec3 project(int width, int height, const Vec3& point) const;
  /// Turned about the focal point: azimuth about view_up, elevation about the axis to the right [deg].
  Camera turned(double azimuth, double elevation) const;
  /// Moved nearer by that factor (> 1) or farther.
  Camera zoomed(double factor) const;
};

/// A camera that sees the whole box between two corners from `direction` (away from the eye is -direction),
/// as ParaView's "reset camera" places it. @param aspect width over height
Camera seeing(const Vec3& low, const Vec3& high, const Vec3& direction, const Vec3& view_up,
              double aspect = 1, bool parallel = false);

/// What lies on the side of `point` that `normal` points away from is cut away.
struct ClipPlane {
  Vec3 point{};
  Vec3 normal{0, 0, 1};
  friend bool operator==(const ClipPlane&, const ClipPlane&) = default;
};

/// What is common to all objects of a picture.
struct View {
  Camera camera;
  int width = 512, height = 512; ///< [pixels], 1 to 16384
  std::vector<ClipPlane> clips;  ///< in the world, of all objects
  double samples_per_voxel = 1;  ///< along rays, > 0
  /// Where the light comes from, in the camera's axes (right, up, towards the eye); need not be of length 1.
  Vec3 light{0, 0, 1};
  double depth_cue = 0; ///< 0 to 1: how dark the farthest point is
  friend bool operator==(const View&, const View&) = default;
};

} // namespace maille::render
