#include "maille/studies/play.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>

namespace maille::studies {

using deform::Drive;
using deform::Pose;

namespace {

Eigen::Vector3d vector(const Vec3& v) {
  return Eigen::Vector3d::Map(v.data());
}

Vec3 array(const Eigen::Vector3d& v) {
  return {v[0], v[1], v[2]};
}

Eigen::Vector3d apply(const Pose& pose, const Eigen::Vector3d& x) {
  return pose.position + pose.rotation * x;
}

/// The frame of an object as the scene places it.
Pose frame_of(const WorldObject& object) {
  Pose pose;
  pose.rotation = Eigen::AngleAxisd(object.turn_angle, vector(object.turn_axis)).toRotationMatrix();
  pose.position = vector(object.position);
  return pose;
}

/// Every node of an object's grid as the scene places it.
std::vector<Vec3> nodes_at_start(const WorldObject& object) {
  const Specimen& body = object.scene.specimen;
  const Pose frame = frame_of(object);
  std::vector<Vec3> nodes;
  nodes.reserve(static_cast<std::size_t>(body.grid.n_nodes()));
  for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node)
    nodes.push_back(array(apply(frame, vector(body.position(body.grid.node_at(node))))));
  return nodes;
}

/// The middle of an object's box, in its own frame.
Eigen::Vector3d middle_of(const Specimen& body) {
  Eigen::Vector3d middle = vector(body.origin);
  for (int a = 0; a < body.grid.dimension(); ++a)
    middle[a] += 0.5 * body.grid.cells()[static_cast<std::size_t>(a)] *
                 body.grid.spacing()[static_cast<std::size_t>(a)];
  return middle;
}

bool is_still(const Drive& drive) {
  return drive.motion.by == Eigen::Vector3d::Zero() && drive.motion.angle == 0;
}

/// What is left of a motion after a fraction of it, along the faces that the object has met; without the turn.
Eigen::Vector3d rest_along_faces(const Drive& drive, double fraction,
                                 const std::vector<deform::WorldContact>& contacts) {
  Eigen::Vector3d rest = (1 - fraction) * drive.motion.by;
  for (const deform::WorldContact& contact : contacts) {
    const bool is_own = contact.object == drive.object, is_others = contact.other == drive.object;
    const int direction = is_own ? contact.direction : -contact.direction;
    if ((is_own || is_others) && rest[contact.axis] * direction > 0)
      rest[contact.axis] = 0;
  }
  return rest;
}

std::vector<PlayedContact> summed(const std::vector<deform::WorldContact>& contacts) {
  std::map<std::pair<int, int>, PlayedContact> sums;
  for (const deform::WorldContact& contact : contacts) {
    auto [sum, is_new] = sums.try_emplace({contact.object, contact.other});
    if (is_new)
      sum->second = {contact.object, contact.other, 0, Eigen::Vector3d::Zero()};
    ++sum->second.voxels;
    sum->second.force += contact.force;
  }
  std::vector<PlayedContact> list;
  for (const auto& [key, sum] : sums)
    list.push_back(sum);
  return list;
}

/// The face that a voxel presses against.
Vec3 place_of(const deform::World& world, const deform::WorldContact& contact) {
  Eigen::Vector3d x;
  if (world.kind(contact.object) == ObjectKind::deformable) {
    x = world.position(contact.object, contact.voxel);
  } else {
    const deform::RigidShape& shape = world.shape(contact.object);
    const Index3 at = shape.index_of(static_cast<std::int32_t>(contact.voxel));
    Eigen::Vector3d rest;
    for (int a = 0; a < 3; ++a)
      rest[a] = (at[static_cast<std::size_t>(a)] + 0.5) * shape.spacing()[static_cast<std::size_t>(a)];
    x = apply(world.pose(contact.object), rest);
  }
  const double cell = world.cell_size()[static_cast<std::size_t>(contact.axis)];
  const double along = std::floor(x[contact.axis] / cell);
  x[contact.axis] = (contact.direction > 0 ? along + 1 : along) * cell;
  return array(x);
}

} // namespace

Player::Player(deform::World world, Trajectory trajectory)
    : trajectory_(std::move(trajectory)), world_(std::move(world)) {
  const WorldScene& scene = world_.scene();
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    start_.push_back(world_.pose(static_cast<int>(i)));
    start_nodes_.push_back(nodes_at_start(scene.objects[i]));
  }
  moment_.objects.resize(scene.objects.size());
  look({});
}

Pose Player::moved_since_start(std::size_t object) const {
  const Pose& now = world_.pose(static_cast<int>(object));
  const Pose& start = start_[object];
  if (now.rotation == start.rotation) { // no rounding of a turn that there was not
    Pose shift;
    shift.position = now.position - start.position;
    return shift;
  }
  Pose moved;
  moved.rotation = now.rotation * start.rotation.transpose();
  moved.position = now.position - moved.rotation * start.position;
  return moved;
}

Drive Player::drive(const DriveSpan& span, std::int64_t frame) const {
  const WorldObject& object = world_.scene().objects[span.object];
  Drive drive;
  drive.object = static_cast<int>(span.object);
  drive.nodes = span.nodes;
  drive.motion.by = vector(span.by) / static_cast<double>(span.n_frames);
  if (object.kind == ObjectKind::deformable)
    return drive;
  const Pose moved = moved_since_start(span.object), frame_now = frame_of(object);
  drive.motion.axis = vector(span.axis);
  drive.motion.angle = span.angle / static_cast<double>(span.n_frames);
  const Eigen::Vector3d point = span.about ? vector(*span.about) : middle_of(object.scene.specimen);
  drive.motion.about = apply(moved, apply(frame_now, point));
  if (span.to) {
    const Eigen::Vector3d from = apply(moved, frame_now.position);
    const Eigen::Vector3d to =
        from + (vector(*span.to) - from) / static_cast<double>(span.end_frame() - frame);
    const Eigen::Vector3d arm = from - drive.motion.about;
    drive.motion.by =
        to - drive.motion.about - Eigen::AngleAxisd(drive.motion.angle, drive.motion.axis) * arm;
  }
  return drive;
}

std::vector<Drive> Player::drives(std::vector<bool>& slides) {
  const std::int64_t frame = n_played_ + 1;
  while (next_span_ < trajectory_.spans.size() && trajectory_.spans[next_span_].first_frame <= frame)
    active_.push_back(next_span_++);
  std::erase_if(active_, [&](std::size_t span) { return trajectory_.spans[span].end_frame() <= frame; });
  std::vector<Drive> list;
  for (const std::size_t i : active_) {
    const DriveSpan& span = trajectory_.spans[i];
    if (span.release) {
      world_.release(static_cast<int>(span.object));
      continue;
    }
    list.push_back(drive(span, frame));
    slides.push_back(span.slide);
  }
  return list;
}

void Player::slide_on(std::vector<Drive> drives, const std::vector<bool>& slides,
                      const deform::FrameBudget& budget, deform::FrameResult& result) {
  std::vector<double> fraction;
  for (const deform::DriveResult& done : result.drives)
    fraction.push_back(done.fraction);
  for (int faces = 0; faces < 3 && result.status != Status::interrupted; ++faces) { // at most one an axis
    std::vector<Drive> rest;
    for (std::size_t i = 0; i < drives.size(); ++i) {
      drives[i].motion.by = slides[i] && fraction[i] < 1
                                ? rest_along_faces(drives[i], fraction[i], result.contacts)
                                : Eigen::Vector3d::Zero();
      drives[i].motion.angle = 0;
      if (!is_still(drives[i]))
        rest.push_back(drives[i]);
    }
    if (rest.empty())
      return;
    deform::FrameResult more = world_.advance(rest, budget);
    std::size_t next = 0;
    for (std::size_t i = 0; i < drives.size(); ++i)
      fraction[i] = is_still(drives[i]) ? 1 : more.drives[next++].fraction;
    result.status = more.status == Status::done ? result.status : more.status;
    result.seconds += more.seconds;
    result.rounds += more.rounds;
    result.contacts = std::move(more.contacts);
    result.handed_on.insert(result.handed_on.end(), more.handed_on.begin(), more.handed_on.end());
  }
}

PlayedFrame Player::next(const Control& control) {
  std::vector<bool> slides;
  const std::vector<Drive> asked = drives(slides);
  deform::FrameBudget budget;
  budget.seconds = world_.scene().frame_budget;
  budget.stop_requested = control.stop_requested;
  budget.threads = control.threads;
  deform::FrameResult result = world_.advance(asked, budget);
  slide_on(asked, slides, budget, result);
  PlayedFrame frame;
  frame.number = ++n_played_;
  frame.status = result.status;
  frame.message = result.message;
  frame.seconds = result.seconds;
  frame.rounds = result.rounds;
  for (std::size_t i = 0; i < result.drives.size(); ++i)
    frame.drives.push_back({asked[i].object, result.drives[i].fraction, result.drives[i].force});
  frame.contacts = summed(result.contacts);
  frame.handed_on = static_cast<std::int64_t>(result.handed_on.size());
  for (const deform::HandOver& handed : result.handed_on)
    frame.moved_on += std::abs(handed.moved);
  look(result.contacts);
  return frame;
}

void Player::look(const std::vector<deform::WorldContact>& contacts) {
  moment_.time = static_cast<double>(n_played_) * trajectory_.frame_seconds;
  const WorldScene& scene = world_.scene();
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    if (scene.objects[i].kind == ObjectKind::fixed && moment_.objects[i])
      continue;
    std::vector<Vec3> nodes = start_nodes_[i];
    const Specimen& body = scene.objects[i].scene.specimen;
    if (scene.objects[i].kind == ObjectKind::deformable) {
      for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node)
        if (body.is_node(body.grid.node_at(node)))
          nodes[static_cast<std::size_t>(node)] = array(world_.position(static_cast<int>(i), node));
    } else if (const Pose moved = moved_since_start(i);
               moved.position != Eigen::Vector3d::Zero() || moved.rotation != Eigen::Matrix3d::Identity()) {
      for (Vec3& node : nodes)
        node = array(apply(moved, vector(node)));
    }
    if (!moment_.objects[i] || *moment_.objects[i] != nodes)
      moment_.objects[i] = std::make_shared<const std::vector<Vec3>>(std::move(nodes));
  }
  moment_.contacts.clear();
  for (const deform::WorldContact& contact : contacts)
    moment_.contacts.push_back(place_of(world_, contact));
}

} // namespace maille::studies
