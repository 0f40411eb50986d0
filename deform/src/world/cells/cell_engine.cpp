#include "world/cells/cell_engine.hpp"

#include "lattice/tolerances.hpp"
#include "maille/deform/probe/touch.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// Part of the estimated effect of pushes that a frame passes on to the next.
constexpr double faded = 0.9;

/// Poses and displacements of all objects.
struct Snapshot {
  explicit Snapshot(const WorldObjects& world) {
    for (int object = 0; object < world.n_objects(); ++object)
      if (world.is_body(object))
        bodies.push_back(world.body(object).displacement());
      else
        poses.push_back(world.rigid.pose(world.member(object).index));
  }
  /// True if no position differs by more than a distance.
  bool is_near(const Snapshot& other, double distance) const {
    for (std::size_t i = 0; i < poses.size(); ++i)
      if ((poses[i].position - other.poses[i].position).norm() > distance ||
          (poses[i].rotation - other.poses[i].rotation).norm() > negligible)
        return false;
    for (std::size_t i = 0; i < bodies.size(); ++i)
      for (std::size_t k = 0; k < bodies[i].values().size(); ++k)
        if (std::abs(bodies[i].values()[k] - other.bodies[i].values()[k]) > distance)
          return false;
    return true;
  }

  std::vector<Displacement> bodies;
  std::vector<Pose> poses;
};

void drive_nodes(WorldObjects& world, const Drive& drive, const RigidMotion& part) {
  DeformableObject& body = world.body(drive.object);
  for (const std::int64_t node : drive.nodes) {
    const std::int32_t voxel = body.lattice().voxel(node);
    const Eigen::Vector3d from = body.lattice().position(voxel, body.displacement());
    auto& handle = body.handles()[node];
    handle.is_driven = true;
    handle.at = body.lattice().displacement_at(voxel, moved_point(part, from));
    if (!body.lattice().is_turned() && part.angle == 0) // unmoved components stay bit-identical
      for (int a = 0; a < world.scene.dimension; ++a)
        if (part.by[a] == 0)
          handle.at[a] = body.displacement()(a, node);
  }
}

/// Moves a rigid object as near to a pose as possible without pushing: it rotates as far as possible, then
/// moves straight and along obstacles (Proxy).
void follow(RigidWorld& rigid, int object, const Pose& goal) {
  const Eigen::Vector3d middle = rigid.shape(object).middle();
  const auto about_middle = [&](const Pose& pose) {
    return Pose{pose.rotation, pose.position + pose.rotation * middle};
  };
  rigid.take_out(object);
  const Surroundings around(&rigid.map(), rigid.cell_size());
  Proxy proxy(rigid.shape(object), about_middle(rigid.pose(object)));
  proxy.follow(around, about_middle(goal));
  rigid.put_back(object, proxy.pose());
}

/// Part of a drive that leads an object by a spring: poses between which no point of the object moves further
/// than a cell.
void lead(FrameRun& frame, std::size_t i, int step, int n) {
  const Drive& drive = frame.drives[i];
  const int index = frame.world.member(drive.object).index;
  const RigidMotion& motion = drive.motion;
  const Eigen::Vector3d middle = frame.world.rigid.shape(index).middle();
  const Eigen::Vector3d at = drive.lead->hand.position + drive.lead->hand.rotation * middle;
  const double way = motion.by.norm() + std::abs(motion.angle) * ((at - motion.about).norm() + middle.norm());
  const double poses = std::ceil(way / *std::ranges::min_element(frame.world.scene.spacing) + 1e-9);
  for (double pose = std::floor(poses * step / n) + 1; pose <= std::floor(poses * (step + 1) / n); ++pose)
    if (frame.clock.has_budget())
      follow(frame.world.rigid, index, motion.moved(drive.lead->hand, pose / poses));
}

void drive(FrameRun& frame, Pushing& pushing, std::size_t i, int step, int n) {
  const Drive& drive = frame.drives[i];
  const RigidMotion part = part_of(drive.motion, static_cast<double>(step) / n, (step + 1.0) / n);
  if (frame.world.is_body(drive.object)) {
    drive_nodes(frame.world, drive, part);
    pushing.unsettled.insert(drive.object);
  } else if (drive.lead) {
    lead(frame, i, step, n);
  } else {
    frame.done[i] += pushing.push_rigid(drive.object, part, drive.slides) / n;
  }
}

void report_contacts(FrameRun& frame) {
  WorldObjects& world = frame.world;
  for (int object = 0; object < world.n_objects(); ++object) {
    if (!world.is_body(object))
      continue;
    const DeformableObject& body = world.body(object);
    for (const Pin& pin : body.pins()) {
      const Index3 wall = wall_of(body, pin);
      if (!pin.self && !body.cells().is_blocked(world.map(), wall))
        continue;
      WorldContact contact{object,       body.lattice().node(pin.voxel), world.object_in(wall), 0, pin.axis,
                           pin.direction};
      if (pin.self) {
        contact.other = object;
        contact.other_voxel = body.lattice().node(*pin.self);
      } else if (contact.other >= 0)
        contact.other_voxel = world.voxel_of(contact.other, world.map().occupant(wall));
      contact.force = Eigen::Vector3d(pin.grip[0], pin.grip[1], pin.grip[2]);
      contact.force[pin.axis] = -pin.direction * pin.pressure;
      frame.result.contacts.push_back(contact);
    }
  }
  for (std::size_t i = 0; i < frame.drives.size(); ++i)
    for (const WorldContact& contact : frame.result.contacts)
      if (contact.other == frame.drives[i].object && !world.is_body(contact.other))
        frame.result.drives[i].force += contact.force;
}

} // namespace

std::unique_ptr<Engine> CellEngine::copy() const {
  auto copy = std::make_unique<CellEngine>(std::make_unique<WorldObjects>(world()));
  copy->effects_ = effects_;
  return copy;
}

FrameResult CellEngine::advance(std::span<const Drive> drives, const FrameBudget& budget) {
  FrameRun frame(*this, drives, budget);
  Pushing pushing(frame, effects_);
  move(frame, pushing);
  return std::move(frame.result);
}

void CellEngine::move(FrameRun& frame, Pushing& pushing) {
  WorldObjects& world = frame.world;
  const int n = frame.n_steps(), last = std::min(n, frame.most_steps());
  if (!frame.clock.rounds_left) // ten steps' rounds, or four a step: every frame is bounded
    frame.clock.rounds_left = std::min(std::int64_t{n} * iteration_cap,
                                       std::max(std::int64_t{10} * iteration_cap, std::int64_t{4} * last));
  for (auto& [faces, effect] : effects_)
    effect.change *= faded;
  for (DeformableObject& body : world.bodies)
    for (Pin& pin : body.pins())
      pin.stays = false;
  const bool shifts_only =
      std::ranges::all_of(frame.drives, [](const Drive& drive) { return drive.motion.angle == 0; });
  const double least = negligible * *std::ranges::min_element(world.scene.spacing);
  for (int step = 0; step < last && frame.clock.has_budget(); ++step) {
    for (auto& [faces, effect] : effects_)
      effect = {effect.change, std::nullopt, 0};
    const Snapshot before(world);
    for (std::size_t i = 0; i < frame.drives.size(); ++i)
      drive(frame, pushing, i, step, n);
    pushing.come_to_rest();
    if (shifts_only && Snapshot(world).is_near(before, least))
      break; // further steps would repeat this one
  }
  bool has_settled = true;
  for (int object = 0; object < world.n_objects(); ++object) {
    bool& is_unsettled = world.member(object).is_unsettled;
    is_unsettled = pushing.unsettled.contains(object) && world.body(object).knows_forces();
    has_settled = has_settled && !is_unsettled;
  }
  frame.report_drives();
  report_contacts(frame);
  for (std::size_t i = 0; i < frame.drives.size(); ++i)
    if (frame.drives[i].lead)
      frame.report_lead(i);
  frame.report_end(has_settled,
                   "bodies push each other to and fro: the frame ended at a feasible state between",
                   "the frame ended before all had settled");
}

} // namespace maille::deform
