#pragma once
/// Drives of a frame from the spans of a trajectory; the same for a live session and a replay.

#include "maille/deform/world/world.hpp"
#include "maille/scene/world/trajectory.hpp"

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

namespace maille::deform {

/// Initial frame of an object, from its scene.
Pose frame_of(const WorldObject& object);
/// Present frame of an object. For fixed and rigid objects the pose in a world is that of the corner of the
/// cells, which may have been cropped to the matter; deformable objects keep their frame.
Pose frame_of(const World& world, std::size_t object);
/// The middle of an object's box, in its own frame [m].
Eigen::Vector3d middle_of(const Specimen& body);

/// Converts spans to drives; stores the initial poses of objects, which spans are relative to.
class TrajectoryDrives {
public:
  /// @param world in its initial state
  explicit TrajectoryDrives(const World& world);

  /// Motion of an object since the initial state.
  Pose moved_since_start(const World& world, std::size_t object) const;
  /// Present frame of a fixed or rigid object; its origin is that of the scene's shape.
  Pose frame_now(const World& world, std::size_t object) const;
  /// Drive of a span without release, in a frame within the span.
  Drive drive(const World& world, const DriveSpan& span, std::int64_t frame) const;
  /// Releases objects as the spans specify, and returns the drives of the other spans, in their order.
  std::vector<Drive> begin_frame(World& world, const std::vector<DriveSpan>& spans, std::int64_t frame);

private:
  std::vector<Pose> start_;
  /// A hand that leads an object: its pose, and the frame of that pose. In the next frame it continues from
  /// there; after a frame without the hand it starts at the pose of the object.
  struct Hand {
    Pose pose;
    std::int64_t frame;
  };
  std::map<std::size_t, Hand> hands_; ///< by object
};

} // namespace maille::deform
