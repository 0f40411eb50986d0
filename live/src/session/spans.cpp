/// Drives of the world in a frame, towards the goal of the hand.

#include "session/physics.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace maille::live {

namespace {

/// Smallest motion that is driven [cells], [rad].
constexpr double is_there = 1e-7;
/// The same for nodes [cells]: `limits` round to single precision, so closer pushes are not possible.
constexpr double are_there = 1e-5;
/// Longest step of a frame [cells]: for worlds of bodies with forces, and for others.
constexpr double elastic_step = 1, rigid_step = 16;
/// Largest rotation of an axis drive in a frame [rad]: the centre moves on a straight line, not on an arc.
constexpr double largest_turn = 0.18;

Vec3 array(const Eigen::Vector3d& v) {
  return {v[0], v[1], v[2]};
}

/// Reduces a rotation to its sign about z in worlds of fewer dimensions.
void keep_in_plane(int dimension, DriveSpan& span) {
  if (dimension == 3)
    return;
  span.angle *= span.axis[2] < 0 ? -1 : 1;
  span.axis = array(Eigen::Vector3d::UnitZ());
  for (int a = dimension; a < 3; ++a)
    (*span.to)[a] = 0;
}

} // namespace

std::vector<DriveSpan> Physics::spans_to_goal() {
  return grip_.nodes.empty() ? spans_of_rigid() : spans_of_nodes();
}

/// Drives held nodes without motion, so that their force is computed; none for other grips.
std::vector<DriveSpan> Physics::spans_of_rest() const {
  if (grip_.object < 0 || grip_.nodes.empty())
    return {};
  DriveSpan span;
  span.object = static_cast<std::size_t>(grip_.object);
  span.nodes = grip_.nodes;
  return {span};
}

double Physics::longest_step() const {
  const WorldScene& scene = timeline_.scene();
  const double cell = *std::min_element(scene.spacing.begin(), scene.spacing.begin() + scene.dimension);
  return (has_soft_bodies(scene) && scene.method != "limits" ? elastic_step : rigid_step) * cell;
}

std::vector<DriveSpan> Physics::spans_of_rigid() {
  const deform::Pose now =
      timeline_.drives().frame_now(timeline_.world(), static_cast<std::size_t>(grip_.object));
  const Eigen::Vector3d way = goal_now_.pose.position - now.position;
  const Eigen::AngleAxisd turn(goal_now_.pose.rotation * now.rotation.transpose());
  const double cell = *std::ranges::min_element(timeline_.scene().spacing);
  const bool is_turned = std::abs(turn.angle()) > is_there;
  if (way.norm() < is_there * cell && !is_turned)
    return {};
  const Grid& grid = timeline_.scene().objects[grip_.object].scene.specimen.grid;
  double arm = 0;
  for (int a = 0; a < grid.dimension(); ++a)
    arm = std::hypot(arm, 0.5 * grid.cells()[a] * grid.spacing()[a]);
  if (goal_now_.axis >= 0)
    return {span_along_axis(now, turn)};
  const double length = way.norm() + (is_turned ? std::abs(turn.angle()) * arm : 0);
  const double part = std::min(1.0, longest_step() / length);
  DriveSpan span;
  span.object = static_cast<std::size_t>(grip_.object);
  span.to = array(part == 1 ? goal_now_.pose.position : Eigen::Vector3d(now.position + part * way));
  if (is_turned) {
    span.axis = array(turn.axis());
    span.angle = part * turn.angle();
  }
  keep_in_plane(timeline_.scene().dimension, span);
  span.slide = true;
  return {span};
}

/// Like screwing on a nut: alternately a small rotation about the centre, and the possible motion along the
/// axis.
DriveSpan Physics::span_along_axis(const deform::Pose& now, const Eigen::AngleAxisd& turn) {
  const WorldScene& scene = timeline_.scene();
  const Specimen& body = scene.objects[grip_.object].scene.specimen;
  const double cell = *std::ranges::min_element(scene.spacing);
  const Eigen::Vector3d way = goal_now_.pose.position - now.position;
  const double along = way[goal_now_.axis];
  const bool shifts = std::abs(along) > is_there * cell, is_turned = std::abs(turn.angle()) > is_there;
  turns_ = is_turned && (!shifts || !turns_);
  DriveSpan span;
  span.object = static_cast<std::size_t>(grip_.object);
  Eigen::Vector3d to = goal_now_.pose.position;
  if (turns_) {
    span.axis = array(turn.axis());
    span.angle = std::clamp(turn.angle(), -largest_turn, largest_turn);
    const Eigen::Vector3d middle = now.position + now.rotation * deform::middle_of(body);
    to = middle + Eigen::AngleAxisd(span.angle, turn.axis()) * (now.position - middle);
  } else if (shifts) {
    to = now.position +
         std::clamp(along, -longest_step(), longest_step()) * Eigen::Vector3d::Unit(goal_now_.axis);
  }
  span.to = array(to);
  keep_in_plane(scene.dimension, span);
  return span;
}

std::vector<DriveSpan> Physics::spans_of_nodes() {
  const deform::World& world = timeline_.world();
  const double cell = *std::ranges::min_element(timeline_.scene().spacing);
  const bool is_turned = !goal_now_.pose.rotation.isIdentity(is_there);
  std::vector<Eigen::Vector3d> ways;
  double longest = 0;
  for (std::size_t i = 0; i < grip_.nodes.size(); ++i) {
    if (i > 0 && !is_turned) {
      ways.push_back(ways.front());
      continue;
    }
    const Eigen::Vector3d to = goal_now_.pose.position + goal_now_.pose.rotation * grip_offsets_[i];
    ways.push_back(to - world.position(grip_.object, grip_.nodes[i]));
    longest = std::max(longest, ways.back().norm());
  }
  if (longest < are_there * cell)
    return {};
  const double part = timeline_.scene().is_open ? 1 : std::min(1.0, longest_step() / longest);
  std::vector<DriveSpan> spans;
  const auto add = [&](std::vector<std::int64_t> nodes, const Eigen::Vector3d& way) {
    DriveSpan& span = spans.emplace_back();
    span.object = static_cast<std::size_t>(grip_.object);
    span.nodes = std::move(nodes);
    span.by = array(part * way);
    for (int a = timeline_.scene().dimension; a < 3; ++a)
      span.by[a] = 0;
  };
  if (!is_turned)
    add(grip_.nodes, ways.front());
  else
    for (std::size_t i = 0; i < grip_.nodes.size(); ++i)
      add({grip_.nodes[i]}, ways[i]);
  return spans;
}

} // namespace maille::live
