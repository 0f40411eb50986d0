#pragma once
/// Drives that the spans of a trajectory request in a frame; the same for a live session and a replay.

#include "maille/deform/world/world.hpp"
#include "maille/scene/world/trajectory.hpp"

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

namespace maille::deform {

/// Where the frame of an object is as its scene places it.
Pose frame_of(const WorldObject& object);
/// Where it is now. A world knows the corner of the cells of what keeps its form, from which matter may have
/// been cropped; what is deformable keeps its frame.
Pose frame_of(const World& world, std::size_t object);
/// The middle of an object's box, in its own frame [m].
Eigen::Vector3d middle_of(const Specimen& body);

/// Knows where the objects of a world were before its first frame, from which spans measure.
class TrajectoryDrives {
public:
  /// @param world as it begins
  explicit TrajectoryDrives(const World& world);

  /// Motion of an object since then.
  Pose moved_since_start(const World& world, std::size_t object) const;
  /// Where the frame of a fixed or rigid object is now, in which its scene has the origin of its shape.
  Pose frame_now(const World& world, std::size_t object) const;
  /// What a span that does not release asks for in a frame that it has part in.
  Drive drive(const World& world, const DriveSpan& span, std::int64_t frame) const;
  /// Releases what is to be released, and lists what else the spans ask for, in their order.
  std::vector<Drive> begin_frame(World& world, const std::vector<DriveSpan>& spans, std::int64_t frame);

private:
  std::vector<Pose> start_;
  /// A hand that leads an object: its pose, and the frame of that pose. In the next frame it continues from
  /// there; a hand that released the object for a frame takes it up where the object is.
  struct Hand {
    Pose pose;
    std::int64_t frame;
  };
  std::map<std::size_t, Hand> hands_; ///< by object
};

} // namespace maille::deform
