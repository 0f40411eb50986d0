#include "maille/deform/world/trajectory_drives.hpp"

#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

namespace maille::deform {

namespace {

Eigen::Vector3d vector(const Vec3& v) {
  return Eigen::Vector3d::Map(v.data());
}

Eigen::Vector3d apply(const Pose& pose, const Eigen::Vector3d& x) {
  return pose.position + pose.rotation * x;
}

} // namespace

Pose frame_of(const WorldObject& object) {
  Pose pose;
  pose.rotation = Eigen::AngleAxisd(object.turn_angle, vector(object.turn_axis)).toRotationMatrix();
  pose.position = vector(object.position);
  return pose;
}

Pose frame_of(const World& world, std::size_t object) {
  const WorldObject& what = world.scene().objects[object];
  if (what.kind == ObjectKind::deformable)
    return frame_of(what);
  Pose frame = world.pose(static_cast<int>(object));
  for (int a = 0; a < world.scene().dimension; ++a)
    frame.position -= frame.rotation.col(a) * what.scene.specimen.origin[a];
  return frame;
}

Eigen::Vector3d middle_of(const Specimen& body) {
  Eigen::Vector3d middle = vector(body.origin);
  for (int a = 0; a < body.grid.dimension(); ++a)
    middle[a] += 0.5 * body.grid.cells()[a] * body.grid.spacing()[a];
  return middle;
}

TrajectoryDrives::TrajectoryDrives(const World& world) {
  for (int object = 0; object < world.n_objects(); ++object)
    start_.push_back(world.pose(object));
}

Pose TrajectoryDrives::moved_since_start(const World& world, std::size_t object) const {
  const Pose& now = world.pose(static_cast<int>(object));
  const Pose& start = start_[object];
  Pose moved;
  if (now.rotation == start.rotation) { // without a rotation, avoids its rounding
    moved.position = now.position - start.position;
    return moved;
  }
  moved.rotation = now.rotation * start.rotation.transpose();
  moved.position = now.position - moved.rotation * start.position;
  return moved;
}

Pose TrajectoryDrives::frame_now(const World& world, std::size_t object) const {
  const Pose moved = moved_since_start(world, object), start = frame_of(world.scene().objects[object]);
  return {moved.rotation * start.rotation, apply(moved, start.position)};
}

Drive TrajectoryDrives::drive(const World& world, const DriveSpan& span, std::int64_t frame) const {
  const WorldObject& object = world.scene().objects[span.object];
  Drive drive;
  drive.object = static_cast<int>(span.object);
  drive.nodes = span.nodes;
  drive.slides = span.slide;
  drive.motion.by = vector(span.by) / static_cast<double>(span.n_frames);
  if (object.kind == ObjectKind::deformable)
    return drive;
  Pose moved = moved_since_start(world, span.object);
  const Pose begin = frame_of(object);
  if (span.follow) { // the drive pose moves, from the pose of the object when it began to lead
    const auto known = hands_.find(span.object);
    const bool continues = known != hands_.end() && known->second.frame == frame - 1;
    const Pose hand = continues ? known->second.pose : world.pose(static_cast<int>(span.object));
    const Pose& start = start_[span.object];
    moved.rotation = hand.rotation * start.rotation.transpose();
    moved.position = hand.position - moved.rotation * start.position;
    drive.lead = Drive::Lead{hand, *span.follow};
  }
  drive.motion.axis = vector(span.axis);
  drive.motion.angle = span.angle / static_cast<double>(span.n_frames);
  const Eigen::Vector3d point = span.about ? vector(*span.about) : middle_of(object.scene.specimen);
  drive.motion.about = apply(moved, apply(begin, point));
  if (span.to) {
    const Eigen::Vector3d from = apply(moved, begin.position);
    const Eigen::Vector3d to =
        from + (vector(*span.to) - from) / static_cast<double>(span.end_frame() - frame);
    const Eigen::Vector3d arm = from - drive.motion.about;
    drive.motion.by =
        to - drive.motion.about - Eigen::AngleAxisd(drive.motion.angle, drive.motion.axis) * arm;
  }
  return drive;
}

std::vector<Drive> TrajectoryDrives::begin_frame(World& world, const std::vector<DriveSpan>& spans,
                                                 std::int64_t frame) {
  std::vector<Drive> list;
  for (const DriveSpan& span : spans) {
    if (span.release) {
      world.release(static_cast<int>(span.object));
      continue;
    }
    list.push_back(drive(world, span, frame));
    if (const Drive& of = list.back(); of.lead)
      hands_[span.object] = {of.motion.moved(of.lead->hand, 1), frame};
  }
  return list;
}

} // namespace maille::deform
