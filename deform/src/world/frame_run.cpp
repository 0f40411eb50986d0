#include "world/frame_run.hpp"

#include "lattice/tolerances.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

void check(const WorldObjects& world, const Drive& drive) {
  const auto fail = [](const char* what) { throw std::invalid_argument(std::string("Drive: ") + what); };
  if (drive.object < 0 || drive.object >= world.n_objects())
    fail("of an object that is not there");
  const RigidMotion& motion = drive.motion;
  double size = world.scene.is_open ? std::numeric_limits<double>::infinity() : 0; // of the world [m]
  for (int a = 0; a < world.scene.dimension; ++a)
    size += world.scene.cells[a] * world.scene.spacing[a];
  // About points further away, a rotation is lost to rounding.
  if (!motion.by.allFinite() || !motion.about.allFinite() || !(motion.about.norm() <= 1e6 * size) ||
      !(motion.by.norm() <= 1e9 * size) || !(std::abs(motion.angle) <= std::numbers::pi) ||
      !(std::abs(motion.axis.norm() - 1) < 1e-9))
    fail("a motion within 1e9 times the world's size, a turn about a point within a million times it, of at "
         "most half a circle, an axis of length 1");
  const Specimen& specimen = world.object(drive.object).scene.specimen;
  switch (world.member(drive.object).kind) {
  case ObjectKind::fixed:
    fail("a fixed object does not move");
    break;
  case ObjectKind::rigid:
    if (!drive.nodes.empty())
      fail("a rigid object moves as a whole: no nodes");
    if (drive.lead && !(drive.lead->stiffness > 0 && drive.lead->hand.position.allFinite() &&
                        drive.lead->hand.rotation.allFinite()))
      fail("a hand somewhere, and a spring of a stiffness above 0");
    break;
  case ObjectKind::deformable:
    for (const std::int64_t node : drive.nodes)
      if (node < 0 || node >= specimen.grid.n_nodes() || !specimen.is_node(specimen.grid.node_at(node)))
        fail("of a node that is not of the body");
  }
}

} // namespace

bool FrameClock::has_budget() {
  if (ended)
    return false;
  if (control.should_stop())
    ended = Status::interrupted;
  else if (rounds_left && *rounds_left <= 0)
    ended = Status::budget_reached;
  else if (const auto left = seconds_left ? seconds_left() : std::nullopt; left && *left <= 0)
    ended = Status::budget_reached;
  else
    control.seconds_budget = left;
  return !ended;
}

void FrameClock::count_round() {
  rounds += 1;
  if (rounds_left)
    --*rounds_left;
}

Eigen::Vector3d moved_point(const RigidMotion& motion, const Eigen::Vector3d& point) {
  return motion.moved({Eigen::Matrix3d::Identity(), point}, 1).position;
}

RigidMotion part_of(const RigidMotion& motion, double begin, double end) {
  RigidMotion part = motion;
  part.about += begin * motion.by;
  part.by *= end - begin;
  part.angle *= end - begin;
  return part;
}

void set_axis(WorldContact& contact, const Eigen::Vector3d& normal) {
  Eigen::Index axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  contact.axis = static_cast<int>(axis);
  contact.direction = normal[axis] > 0 ? -1 : 1;
}

FrameRun::FrameRun(Engine& of, std::span<const Drive> wanted, const FrameBudget& budget)
    : engine(of), world(of.world()), drives(wanted), seconds(budget.seconds), duration(budget.frame_seconds),
      done(wanted.size(), 0) {
  for (const Drive& drive : drives)
    check(world, drive);
  clock.control.threads = budget.threads;
  clock.control.stop_requested = budget.stop_requested;
  clock.rounds_left = budget.rounds;
  clock.seconds_left = [this]() -> std::optional<double> {
    return seconds ? std::optional(*seconds - seconds_so_far()) : std::nullopt;
  };
  for (const Drive& drive : drives) {
    std::vector<Eigen::Vector3d>& before = nodes_before.emplace_back();
    for (const std::int64_t node : drive.nodes)
      before.push_back(engine.position(drive.object, node));
    world.member(drive.object).is_driven = true;
  }
}

int FrameRun::n_steps() const {
  double most = 1;
  for (std::size_t i = 0; i < drives.size(); ++i) {
    const RigidMotion& motion = drives[i].motion;
    double arm = 0;
    if (world.is_body(drives[i].object))
      for (const Eigen::Vector3d& point : nodes_before[i])
        arm = std::max(arm, (point - motion.about).norm());
    else
      arm = (engine.pose(drives[i].object).position - motion.about).norm() +
            2 * world.rigid.shape(world.member(drives[i].object).index).middle().norm();
    for (int a = 0; a < world.scene.dimension; ++a)
      most = std::max(most, (std::abs(motion.by[a]) + std::abs(motion.angle) * arm) / world.scene.spacing[a]);
  }
  return static_cast<int>(std::ceil(std::min(most * (1 - 1e-12), 2e9)));
}

void FrameRun::report_drives() {
  result.drives.resize(drives.size());
  for (std::size_t i = 0; i < drives.size(); ++i) {
    const Drive& drive = drives[i];
    if (!world.is_body(drive.object)) {
      result.drives[i].fraction = std::min(1.0, done[i]);
      continue;
    }
    double sum = 0;
    for (std::size_t k = 0; k < drive.nodes.size(); ++k) {
      const Eigen::Vector3d& before = nodes_before[i][k];
      const Eigen::Vector3d wanted = moved_point(drive.motion, before) - before,
                            moved = engine.position(drive.object, drive.nodes[k]) - before;
      sum += wanted.isZero(0) ? 1 : moved.dot(wanted) / wanted.squaredNorm();
    }
    result.drives[i].fraction = drive.nodes.empty() ? 1 : sum / static_cast<double>(drive.nodes.size());
    if (world.scene.is_open)
      continue;
    const DeformableObject& body = world.body(drive.object);
    for (const std::int64_t node : drive.nodes)
      if (const auto handle = body.handles().find(node);
          handle != body.handles().end()) { // else it is not driven yet
        const Vec3& force = handle->second.force;
        result.drives[i].force +=
            body.lattice().pose().rotation * Eigen::Vector3d(force[0], force[1], force[2]);
      }
  }
}

void FrameRun::report_lead(std::size_t i) {
  const Drive& drive = drives[i];
  const Pose& pose = engine.pose(drive.object);
  const Eigen::Vector3d middle = world.rigid.shape(world.member(drive.object).index).middle();
  const Pose end = drive.motion.moved(drive.lead->hand, 1);
  const Eigen::Vector3d behind =
      end.position + end.rotation * middle - pose.position - pose.rotation * middle;
  const double turn = Eigen::AngleAxisd(end.rotation * pose.rotation.transpose()).angle(),
               way = drive.motion.by.norm() + std::abs(drive.motion.angle) * middle.norm();
  result.drives[i].force = drive.lead->stiffness * behind;
  const double left = behind.norm() + turn * middle.norm();
  result.drives[i].fraction = way > 0 ? std::clamp(1 - left / way, 0.0, 1.0) : 1.0;
}

std::string FrameRun::first_cut_drive() const {
  const auto cut = std::ranges::find_if(
      result.drives, [](const DriveResult& drive) { return drive.fraction < 1 - negligible; });
  if (cut == result.drives.end())
    return "";
  const int object = drives[cut - result.drives.begin()].object;
  std::string text = fmt::format("object `{}` came {:.3g} % of its way", world.name(object),
                                 cut->fraction > negligible ? 100 * cut->fraction : 0.0);
  for (const WorldContact& contact : result.contacts)
    if ((contact.object == object) != (contact.other == object)) {
      const int other = contact.object == object ? contact.other : contact.object;
      return text + " and touches " + (other < 0 ? "the border" : "object `" + world.name(other) + "`");
    }
  return text;
}

void FrameRun::report_end(bool has_settled, const char* endless, const char* cut_short) {
  result.rounds = clock.rounds;
  std::string cut = first_cut_drive();
  if (clock.ended) {
    result.status = *clock.ended;
    result.message = cut_short;
  } else if (!rollback_reason.empty()) {
    result.status = has_settled ? Status::clamped : Status::budget_reached;
    result.message = rollback_reason;
  } else if (!has_settled) {
    result.status = Status::budget_reached;
    result.message = endless;
  } else if (!cut.empty() || !result.message.empty()) {
    result.status = Status::clamped;
    if (result.message.empty())
      result.message = std::move(cut);
  }
  result.seconds = seconds_so_far();
}

} // namespace maille::deform
