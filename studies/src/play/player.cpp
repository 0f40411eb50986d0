#include "play/play.hpp"

#include <Eigen/Geometry>

#include <cmath>
#include <map>
#include <set>

namespace maille::studies {

using deform::Drive;
using deform::Pose;

namespace {

Eigen::Vector3d vector(const Vec3& v) {
  return Eigen::Vector3d::Map(v.data());
}

Eigen::Vector3d apply(const Pose& pose, const Eigen::Vector3d& x) {
  return pose.position + pose.rotation * x;
}

/// Initial positions of all nodes of an object's grid.
std::vector<Vec3> nodes_at_start(const WorldObject& object) {
  const Specimen& body = object.scene.specimen;
  const Pose frame = deform::frame_of(object);
  std::vector<Vec3> nodes;
  nodes.reserve(body.grid.n_nodes());
  for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node)
    nodes.push_back(array(apply(frame, vector(body.position(body.grid.node_at(node))))));
  return nodes;
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

/// Centre of a voxel of a rigid object.
Eigen::Vector3d centre_of(const deform::World& world, int object, std::int32_t voxel) {
  return apply(world.pose(object), world.shape(object).centre_of(voxel));
}

/// Adds contacts of voxels of a rigid object at a cell face with something behind it: a motion stops a
/// billionth of a cell before that face.
void add_touching(const deform::World& world, int object, std::vector<deform::WorldContact>& contacts) {
  constexpr double reach = 1e-6; // of a cell
  for (std::int32_t voxel = 0; voxel < world.shape(object).n_voxels(); ++voxel) {
    const Eigen::Vector3d x = centre_of(world, object, voxel);
    Index3 cell{};
    for (std::size_t a = 0; a < 3; ++a)
      cell[a] = static_cast<int>(std::floor(x[static_cast<Eigen::Index>(a)] / world.cell_size()[a]));
    for (int axis = 0; axis < world.scene().dimension; ++axis) {
      const std::size_t a = axis;
      const double within = x[axis] / world.cell_size()[a] - cell[a];
      const int direction = within < reach ? -1 : within > 1 - reach ? 1 : 0;
      Index3 next = cell;
      next[a] += direction;
      if (direction == 0 || !world.map().is_blocked(next))
        continue;
      deform::WorldContact contact{object, voxel, -1, 0, axis, direction};
      if (world.map().has_cell(next)) {
        const auto other = world.occupant(world.map().occupant(next));
        contact.other = other.object;
        contact.other_voxel = other.voxel;
      }
      // The world itself reports contacts of deformable objects.
      if (contact.other != object &&
          (contact.other < 0 || world.kind(contact.other) != ObjectKind::deformable))
        contacts.push_back(contact);
    }
  }
}

/// Adds contacts of the boxes of its voxels, where centres do not touch; deformable objects report their own
/// contacts.
void add_touching_boxes(const deform::World& world, int object, std::vector<deform::WorldContact>& contacts) {
  for (const deform::WorldContact& contact : world.touched(object, 1e-6))
    if (world.kind(contact.other) != ObjectKind::deformable)
      contacts.push_back(contact);
}

/// Centre of the face that a voxel touches.
Vec3 place_of(const deform::World& world, const deform::WorldContact& contact) {
  if (contact.at)
    return array(*contact.at);
  Eigen::Vector3d x;
  if (world.kind(contact.object) == ObjectKind::deformable) {
    x = world.position(contact.object, contact.voxel);
  } else {
    x = centre_of(world, contact.object, static_cast<std::int32_t>(contact.voxel));
  }
  const double cell = world.cell_size()[contact.axis];
  const double along = std::floor(x[contact.axis] / cell);
  x[contact.axis] = (contact.direction > 0 ? along + 1 : along) * cell;
  return array(x);
}

} // namespace

Player::Player(deform::World world, Trajectory trajectory)
    : trajectory_(std::move(trajectory)), world_(std::move(world)), drives_of_(world_) {
  const WorldScene& scene = world_.scene();
  for (const WorldObject& object : scene.objects)
    start_nodes_.push_back(nodes_at_start(object));
  moment_.objects.resize(scene.objects.size());
  look({});
}

std::vector<Drive> Player::drives() {
  const std::int64_t frame = n_played_ + 1;
  while (next_span_ < trajectory_.spans.size() && trajectory_.spans[next_span_].first_frame <= frame)
    active_.push_back(next_span_++);
  std::erase_if(active_, [&](std::size_t span) { return trajectory_.spans[span].end_frame() <= frame; });
  std::vector<DriveSpan> spans;
  for (const std::size_t i : active_)
    spans.push_back(trajectory_.spans[i]);
  return drives_of_.begin_frame(world_, spans, frame);
}

PlayedFrame Player::next(const Control& control) {
  const std::vector<Drive> asked = drives();
  deform::FrameBudget budget;
  budget.seconds = world_.scene().frame_budget;
  budget.stop_requested = control.stop_requested;
  budget.threads = control.threads;
  budget.frame_seconds = trajectory_.frame_seconds;
  deform::FrameResult result = world_.advance(asked, budget);
  std::set<int> driven;
  for (const Drive& done : asked)
    if (world_.scene().contact != ContactLaw::surfaces && world_.kind(done.object) == ObjectKind::rigid &&
        driven.insert(done.object).second) {
      add_touching(world_, done.object, result.contacts);
      add_touching_boxes(world_, done.object, result.contacts);
    }
  PlayedFrame frame;
  frame.number = ++n_played_;
  frame.status = result.status;
  frame.message = result.message;
  frame.seconds = result.seconds;
  frame.rounds = result.rounds;
  frame.motion_left = result.motion_left;
  frame.force_left = result.force_left;
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
          nodes[node] = array(world_.position(static_cast<int>(i), node));
    } else if (const Pose moved = drives_of_.moved_since_start(world_, i);
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
