#include "world/world_frame.hpp"

#include "lattice/tolerances.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <numbers>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// Share of the learned effect of pushes that a frame passes on to the next.
constexpr double faded = 0.9;

void check(const WorldParts& parts, const Drive& drive) {
  const auto fail = [](const char* what) { throw std::invalid_argument(std::string("Drive: ") + what); };
  if (drive.object < 0 || drive.object >= parts.n_objects())
    fail("of an object that is not there");
  const RigidMotion& motion = drive.motion;
  double size = 0; // of the world [m]
  for (int a = 0; a < parts.scene.dimension; ++a)
    size += parts.scene.cells[static_cast<std::size_t>(a)] * parts.scene.spacing[static_cast<std::size_t>(a)];
  // About a point further away a turn is rounding.
  if (!motion.by.allFinite() || !(motion.about.norm() <= 1e6 * size) ||
      !(std::abs(motion.angle) <= std::numbers::pi) || !(std::abs(motion.axis.norm() - 1) < 1e-9))
    fail("a finite motion, a turn about a point within a million times the world's size, of at most half a "
         "circle, an axis of length 1");
  switch (parts.member(drive.object).kind) {
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
    const DeformableObject& body = parts.body(drive.object);
    for (const std::int64_t node : drive.nodes)
      if (node < 0 || node >= body.scene().specimen.grid.n_nodes() || body.lattice().voxel(node) < 0)
        fail("of a node that is not of the body");
  }
}

/// Steps after which a drive has crossed the whole world in any direction: the rest of its way leads out.
int most_steps(const WorldScene& scene) {
  return 8 * (scene.cells[0] + scene.cells[1] + scene.cells[2]);
}

} // namespace

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

WorldFrame::WorldFrame(WorldParts& parts, std::span<const Drive> drives, const FrameBudget& budget)
    : parts_(parts), drives_(drives), frame_seconds_(budget.frame_seconds), rigid_done_(drives.size(), 0) {
  for (const Drive& drive : drives)
    check(parts, drive);
  clock_.control.threads = budget.threads;
  clock_.control.stop_requested = budget.stop_requested;
  clock_.rounds_left = budget.rounds;
  const auto seconds = budget.seconds;
  clock_.seconds_left = [this, seconds]() -> std::optional<double> {
    if (!seconds)
      return std::nullopt;
    return *seconds - std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  };
  for (int object = 0; object < parts.n_objects(); ++object)
    if (parts.member(object).is_unsettled || (parts.is_body(object) && parts.body(object).relaxes_on()))
      unsettled_.insert(object);
  for (const Drive& drive : drives) {
    std::vector<Eigen::Vector3d>& before = nodes_before_.emplace_back();
    for (const std::int64_t node : drive.nodes) {
      const DeformableObject& body = parts.body(drive.object);
      before.push_back(body.lattice().position(body.lattice().voxel(node), body.displacement()));
    }
    parts_.member(drive.object).is_driven = true;
  }
}

std::string WorldFrame::name(int object) const {
  return object < 0 ? "the border of the world" : parts_.scene.objects[static_cast<std::size_t>(object)].name;
}

FrameResult WorldFrame::run() {
  if (parts_.dynamics)
    return run_dynamic(frame_seconds_);
  if (parts_.soft_dynamics)
    return run_soft_dynamic(frame_seconds_);
  if (parts_.balance)
    return run_balanced();
  if (parts_.scene.method == "hand_on")
    return run_handed_on();
  const int n = n_steps(), last = std::min(n, most_steps(parts_.scene));
  if (!clock_.rounds_left) // ten steps' worth, or four rounds a step: no frame is without a bound
    clock_.rounds_left = std::min(std::int64_t{n} * iteration_cap,
                                  std::max(std::int64_t{10} * iteration_cap, std::int64_t{4} * last));
  for (auto& [faces, push] : parts_.pushes)
    push.change *= faded;
  for (DeformableObject& body : parts_.bodies)
    for (Pin& pin : body.pins())
      pin.stays = false;
  for (int step = 0; step < last && clock_.may_go_on(); ++step) {
    for (auto& [faces, push] : parts_.pushes)
      push = {push.change, std::nullopt, 0};
    const Moment before = moment();
    for (std::size_t i = 0; i < drives_.size(); ++i)
      drive(i, step, n);
    come_to_rest();
    if (is_as_it_was(before) &&
        shifts_only()) // and so would be after every further step, which asks for the same
      break;
  }
  report();
  return std::move(result_);
}

WorldFrame::Moment WorldFrame::moment() const {
  Moment now;
  for (int object = 0; object < parts_.n_objects(); ++object)
    if (parts_.is_body(object))
      now.bodies.push_back(parts_.body(object).displacement());
    else
      now.poses.push_back(parts_.rigid.pose(parts_.member(object).index));
  return now;
}

bool WorldFrame::is_as_it_was(const Moment& before) const {
  const Vec3& cell = parts_.scene.spacing;
  const double least = negligible * *std::ranges::min_element(cell);
  const Moment now = moment();
  for (std::size_t i = 0; i < now.poses.size(); ++i)
    if ((now.poses[i].position - before.poses[i].position).norm() > least ||
        (now.poses[i].rotation - before.poses[i].rotation).norm() > negligible)
      return false;
  for (std::size_t i = 0; i < now.bodies.size(); ++i)
    for (std::size_t k = 0; k < now.bodies[i].values().size(); ++k)
      if (std::abs(now.bodies[i].values()[k] - before.bodies[i].values()[k]) > least)
        return false;
  return true;
}

bool WorldFrame::shifts_only() const {
  return std::ranges::all_of(drives_, [](const Drive& drive) { return drive.motion.angle == 0; });
}

/// Steps of a frame: nothing driven moves further than a cell along any axis in one.
int WorldFrame::n_steps() const {
  double most = 1;
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    const Drive& drive = drives_[i];
    double arm = 0;
    if (parts_.is_body(drive.object))
      for (const auto& point : nodes_before_[i])
        arm = std::max(arm, (point - drive.motion.about).norm());
    else {
      const auto& rigid = parts_.rigid;
      const int index = parts_.member(drive.object).index;
      const RigidShape& shape = rigid.shape(index);
      Eigen::Vector3d size;
      for (int a = 0; a < 3; ++a)
        size[a] = shape.size()[static_cast<std::size_t>(a)] * shape.spacing()[static_cast<std::size_t>(a)];
      arm = (rigid.pose(index).position - drive.motion.about).norm() + size.norm();
    }
    for (int a = 0; a < parts_.scene.dimension; ++a)
      most = std::max(most, (std::abs(drive.motion.by[a]) + std::abs(drive.motion.angle) * arm) /
                                parts_.scene.spacing[static_cast<std::size_t>(a)]);
  }
  return static_cast<int>(std::ceil(std::min(most * (1 - 1e-12), 2e9)));
}

void WorldFrame::drive(std::size_t i, int step, int n) {
  const Drive& drive = drives_[i];
  const RigidMotion part = part_of(drive.motion, static_cast<double>(step) / n, (step + 1.0) / n);
  if (parts_.is_body(drive.object))
    drive_nodes(drive, part);
  else if (drive.lead)
    lead(i, step, n);
  else
    rigid_done_[i] += push_rigid(drive.object, part, drive.slides) / n;
}

void WorldFrame::drive_nodes(const Drive& drive, const RigidMotion& part) {
  DeformableObject& body = parts_.body(drive.object);
  for (const std::int64_t node : drive.nodes) {
    const std::int32_t voxel = body.lattice().voxel(node);
    const Eigen::Vector3d from = body.lattice().position(voxel, body.displacement());
    auto& handle = body.handles()[node];
    handle.is_driven = true;
    handle.at = body.lattice().displacement_at(voxel, moved_point(part, from));
    if (!body.lattice().is_turned() && part.angle == 0) // components that do not move stay to the bit
      for (int a = 0; a < parts_.scene.dimension; ++a)
        if (part.by[a] == 0)
          handle.at[static_cast<std::size_t>(a)] = body.displacement()(a, node);
  }
  unsettled_.insert(drive.object);
}

/// Settles bodies until none wants to go on.
void WorldFrame::come_to_rest() {
  for (int turn = 0; turn < iteration_cap && clock_.may_go_on(); ++turn) {
    for (int object = 0; object < parts_.n_objects(); ++object)
      if (parts_.is_body(object) && parts_.body(object).knows_forces() &&
          Settling(parts_.map(), parts_.body(object), 0, clock_).has_walls_that_are_gone())
        unsettled_.insert(object);
    if (unsettled_.empty())
      break;
    settle(*unsettled_.begin());
  }
  for (DeformableObject& body : parts_.bodies)
    body.settle_handles();
}

std::string WorldFrame::first_cut_drive() const {
  const auto cut = std::ranges::find_if(
      result_.drives, [](const DriveResult& drive) { return drive.fraction < 1 - negligible; });
  return cut == result_.drives.end()
             ? ""
             : fmt::format("object `{}` came {:.3g} % of its way",
                           name(drives_[static_cast<std::size_t>(cut - result_.drives.begin())].object),
                           cut->fraction > negligible ? 100 * cut->fraction : 0.0);
}

void WorldFrame::report_end(bool has_settled, const char* endless, const char* cut_short) {
  result_.rounds = clock_.rounds;
  if (clock_.ended) {
    result_.status = *clock_.ended;
    result_.message = cut_short;
  } else if (!crossed_.empty()) {
    result_.status = has_settled ? Status::clamped : Status::budget_reached;
    result_.message = crossed_;
  } else if (!has_settled) {
    result_.status = Status::budget_reached;
    result_.message = endless;
  } else if (std::string cut = first_cut_drive(); !cut.empty()) {
    result_.status = Status::clamped;
    result_.message = std::move(cut);
  }
  result_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

void WorldFrame::report() {
  for (int object = 0; object < parts_.n_objects(); ++object)
    parts_.member(object).is_unsettled = unsettled_.contains(object) && parts_.body(object).knows_forces();
  result_.rounds = clock_.rounds;
  for (std::size_t i = 0; i < drives_.size(); ++i)
    report_drive(i);
  report_contacts();
  std::string cut = first_cut_drive();
  if (clock_.ended) {
    result_.status = *clock_.ended;
    result_.message = "the frame ended before all had settled";
  } else if (std::ranges::any_of(unsettled_,
                                 [this](int object) { return parts_.body(object).knows_forces(); })) {
    result_.status = Status::budget_reached;
    result_.message = "bodies push each other to and fro: the frame ended at a feasible state between";
  } else if (!result_.message.empty() && std::ranges::any_of(parts_.bodies, &DeformableObject::relaxes_on)) {
    result_.status = Status::budget_reached; // on its way; the next frame goes on
  } else if (!cut.empty() || !result_.message.empty()) {
    result_.status = Status::clamped;
    if (result_.message.empty())
      result_.message = std::move(cut);
  }
  result_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

void WorldFrame::report_drive(std::size_t i) {
  const Drive& drive = drives_[i];
  DriveResult& drive_result = result_.drives.emplace_back();
  if (!parts_.is_body(drive.object)) {
    drive_result.fraction = std::min(1.0, rigid_done_[i]);
    return;
  }
  const DeformableObject& body = parts_.body(drive.object);
  double sum = 0;
  for (std::size_t k = 0; k < drive.nodes.size(); ++k) {
    const std::int64_t node = drive.nodes[k];
    const Eigen::Vector3d& before = nodes_before_[i][k];
    const Eigen::Vector3d wanted = moved_point(drive.motion, before) - before,
                          done = body.lattice().position(body.lattice().voxel(node), body.displacement()) -
                                 before;
    sum += wanted.isZero(0) ? 1 : done.dot(wanted) / wanted.squaredNorm();
    const auto handle = body.handles().find(node);
    if (handle == body.handles().end()) // the frame ended before it was driven
      continue;
    const Vec3& force = handle->second.force;
    drive_result.force += body.lattice().pose().rotation * Eigen::Vector3d(force[0], force[1], force[2]);
  }
  drive_result.fraction = drive.nodes.empty() ? 1 : sum / static_cast<double>(drive.nodes.size());
}

void WorldFrame::report_contacts() {
  for (int object = 0; object < parts_.n_objects(); ++object) {
    if (!parts_.is_body(object))
      continue;
    const DeformableObject& body = parts_.body(object);
    for (const Pin& pin : body.pins()) {
      const Index3 wall = wall_of(body, pin);
      if (!pin.self && !body.cells().is_blocked(parts_.map(), wall))
        continue;
      WorldContact contact{object,       body.lattice().node(pin.voxel), parts_.object_in(wall), 0, pin.axis,
                           pin.direction};
      if (pin.self) {
        contact.other = object;
        contact.other_voxel = body.lattice().node(*pin.self);
      } else if (contact.other >= 0)
        contact.other_voxel = parts_.voxel_of(contact.other, parts_.map().occupant(wall));
      contact.force = Eigen::Vector3d(pin.grip[0], pin.grip[1], pin.grip[2]);
      contact.force[pin.axis] = -pin.direction * pin.pressure;
      result_.contacts.push_back(contact);
    }
  }
  for (std::size_t i = 0; i < drives_.size(); ++i)
    for (const WorldContact& contact : result_.contacts)
      if (contact.other == drives_[i].object && !parts_.is_body(contact.other))
        result_.drives[i].force += contact.force;
  for (std::size_t i = 0; i < drives_.size(); ++i)
    if (drives_[i].lead)
      report_lead(i);
}

FrameResult World::advance(std::span<const Drive> drives, const FrameBudget& budget) {
  return parts_->lone ? parts_->lone->advance(drives, budget) : WorldFrame(*parts_, drives, budget).run();
}

} // namespace maille::deform
