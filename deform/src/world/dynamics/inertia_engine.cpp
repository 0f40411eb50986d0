#include "world/dynamics/inertia_engine.hpp"

#include "lattice/tolerances.hpp"
#include "maille/scene/block_frames.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <utility>

namespace maille::deform {

namespace {

/// Largest time step [s]. Longer steps damp fast motions more.
constexpr double longest_step = 1e-3;

Eigen::Vector3d turn_between(const Pose& from, const Pose& to) {
  const Eigen::AngleAxisd turn(to.rotation * from.rotation.transpose());
  return turn.angle() * turn.axis();
}

} // namespace

InertiaEngine::InertiaEngine(std::unique_ptr<WorldObjects> of)
    : SurfaceEngine(std::move(of)), gravity_(Eigen::Vector3d::Map(world().scene.dynamics->gravity.data())),
      damping_(world().scene.dynamics->damping), nodes_(static_cast<std::size_t>(world().n_objects())),
      from_(static_cast<std::size_t>(world().n_objects())) {
  if (world().scene.dynamics->restitution > 0)
    throw std::invalid_argument("World: dynamics: restitution 0 beside deformable objects, which rebound by "
                                "their elasticity");
  const int d = world().scene.dimension;
  for (int object = 0; object < world().n_objects(); ++object) {
    const WorldObject& what = world().scene.objects[object];
    moving_.emplace_back(what, d, world().member(object).kind != ObjectKind::fixed);
    if (!world().is_body(object))
      continue;
    const PosedLattice& lattice = world().body(object).lattice();
    const Specimen& body = what.scene.specimen;
    const Grid& grid = body.grid;
    Nodes& nodes = nodes_[object];
    const std::int64_t n = lattice.n_voxels();
    nodes.mass = nodes.velocity = nodes.before = Eigen::VectorXd::Zero(d * n);
    nodes.rest.resize(3, n);
    for (std::int32_t voxel = 0; voxel < n; ++voxel) {
      nodes.rest.col(voxel) =
          lattice.pose().rotation.transpose() * (lattice.rest(voxel) - lattice.pose().position);
      for (int b = 0; b < d; ++b)
        nodes.velocity[std::int64_t{d} * voxel + b] =
            lattice.pose().rotation.col(b).dot(Eigen::Vector3d::Map(what.velocity.data()));
    }
    const double of_corner =
        moving_.back().mass / static_cast<double>(body.n_matter_cells()) / grid.corners_per_cell();
    for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell)
      for (int corner = 0; body.is_matter(cell) && corner < grid.corners_per_cell(); ++corner)
        nodes.mass.segment(std::int64_t{d} * lattice.voxel(grid.corner(grid.cell_at(cell), corner)), d)
            .array() += of_corner;
  }
}

bool InertiaEngine::is_held(int object) const {
  const DeformableObject& body = world().body(object);
  return !body.scene().prescribed.empty() || !body.handles().empty();
}

Eigen::Matrix3Xd InertiaEngine::displaced(int object) const {
  const SurfaceObject& one = balance_.object(object);
  Eigen::Matrix3Xd at = nodes_[object].rest;
  for (Eigen::Index node = 0; node < at.cols(); ++node)
    at.col(node) += one.soft->displacement_at(one.dimension * node);
  return at;
}

Eigen::Matrix3Xd InertiaEngine::places(int object) const {
  const Pose& pose = balance_.object(object).pose;
  return (pose.rotation * displaced(object)).colwise() + pose.position;
}

void InertiaEngine::hold(double step) {
  for (int object = 0; object < world().n_objects(); ++object) {
    SurfaceObject& one = balance_.object(object);
    MovingObject& moving = moving_[object];
    if (one.is_body()) {
      const Pose& at_first = world().body(object).lattice().pose();
      if (is_held(object) &&
          (one.pose.rotation != at_first.rotation || one.pose.position != at_first.position))
        put_into_frame(object, at_first);
      // Damping acts on the velocity at the end of the step, as inertia does.
      one.soft->set_inertia((1 + damping_ * step) / (step * step) * nodes_[object].mass);
      continue;
    }
    moving.has_mass = one.kind == ObjectKind::rigid && !world().member(object).is_driven;
    one.centre.reset();
    one.rigid.set_inertia(std::nullopt);
    if (moving.has_mass)
      one.centre = moving.centre;
    one.place();
  }
}

void InertiaEngine::fly(double step) {
  const double kept = 1 / (1 + damping_ * step);
  for (int object = 0; object < world().n_objects(); ++object) {
    SurfaceObject& one = balance_.object(object);
    const auto i = static_cast<std::size_t>(object);
    if (one.is_body()) {
      Nodes& nodes = nodes_[i];
      const Eigen::VectorXd gravity = (step * one.pose.rotation.transpose() * gravity_)
                                          .head(one.dimension)
                                          .replicate(nodes.rest.cols(), 1);
      nodes.before = one.soft->displacement();
      nodes.velocity = kept * (nodes.velocity + gravity);
      one.soft->set_carried(nodes.before + step * nodes.velocity);
      continue;
    }
    MovingObject& moving = moving_[i];
    from_[i] = one.pose;
    if (!moving.has_mass)
      continue;
    moving.velocity = kept * (moving.velocity + step * gravity_);
    moving.spin *= kept;
    one.rigid.target = shifted_and_turned(moving, one.pose, step * moving.velocity, step * moving.spin);
    Matrix6 inertia = Matrix6::Zero();
    inertia.topLeftCorner<3, 3>() = moving.mass / (kept * step * step) * Eigen::Matrix3d::Identity();
    inertia.bottomRightCorner<3, 3>() = moving.inertia_in_world(one.pose) / (kept * step * step);
    one.rigid.set_inertia(inertia);
  }
}

void InertiaEngine::arrive(double step) {
  for (int object = 0; object < world().n_objects(); ++object) {
    SurfaceObject& one = balance_.object(object);
    const auto i = static_cast<std::size_t>(object);
    if (one.is_body()) {
      nodes_[i].velocity = (one.soft->displacement() - nodes_[i].before) / step;
      if (!is_held(object))
        put_into_frame(object, nearest_frame(object));
      continue;
    }
    MovingObject& moving = moving_[i];
    moving.velocity = (moving.place(one.pose) - moving.place(from_[i])) / step;
    moving.spin = turn_between(from_[i], one.pose) / step;
    if (moving.has_mass)
      one.rigid.target.reset();
  }
}

bool InertiaEngine::is_still(double step) const {
  double fastest = 0; // [m/s]
  for (int object = 0; object < world().n_objects(); ++object) {
    const double arm = balance_.object(object).box.diagonal().norm();
    fastest = std::max(fastest, world().is_body(object)
                                    ? nodes_[object].velocity.cwiseAbs().maxCoeff()
                                    : moving_[object].velocity.norm() + arm * moving_[object].spin.norm());
  }
  return fastest * step < tolerance * balance_.cell();
}

Pose InertiaEngine::nearest_frame(int object) const {
  const Nodes& nodes = nodes_[object];
  const int d = world().scene.dimension;
  const Eigen::Matrix3Xd at = places(object);
  Eigen::VectorXd mass(at.cols());
  for (Eigen::Index node = 0; node < at.cols(); ++node)
    mass[node] = nodes.mass[d * node];
  const Eigen::Vector3d middle = at * mass / mass.sum(), rest = nodes.rest * mass / mass.sum();
  const Eigen::Matrix3d turned =
      (at.colwise() - middle) * mass.asDiagonal() * (nodes.rest.colwise() - rest).transpose();
  Pose frame;
  const Eigen::Quaterniond before(balance_.object(object).pose.rotation);
  frame.rotation = nearest_rotation(d, turned, before).toRotationMatrix();
  frame.position = middle - frame.rotation * rest;
  return frame;
}

/// Transforms positions and velocities into another frame.
void InertiaEngine::put_into_frame(int object, const Pose& frame) {
  SurfaceObject& one = balance_.object(object);
  Nodes& nodes = nodes_[object];
  const int d = one.dimension;
  const Eigen::Matrix3Xd at = places(object);
  const Eigen::Matrix3d turn = frame.rotation.transpose() * one.pose.rotation;
  Eigen::VectorXd displacement = one.soft->displacement();
  for (Eigen::Index node = 0; node < at.cols(); ++node) {
    const Eigen::Vector3d u =
        frame.rotation.transpose() * (at.col(node) - frame.position) - nodes.rest.col(node);
    Eigen::Vector3d speed = Eigen::Vector3d::Zero();
    speed.head(d) = nodes.velocity.segment(d * node, d);
    speed = turn * speed;
    displacement.segment(d * node, d) = u.head(d);
    nodes.velocity.segment(d * node, d) = speed.head(d);
  }
  one.soft->set_displacement(std::move(displacement));
  one.pose = frame;
  one.place();
}

ObjectMotion InertiaEngine::motion(int object) const {
  const auto i = static_cast<std::size_t>(object);
  const SurfaceObject& one = balance_.object(object);
  if (!one.is_body())
    return {moving_[i].mass, moving_[i].velocity, moving_[i].spin, moving_[i].place(one.pose)};
  const Nodes& nodes = nodes_[i];
  const int d = one.dimension;
  const Eigen::Matrix3Xd at = places(object);
  ObjectMotion motion;
  motion.mass = moving_[i].mass;
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
  for (Eigen::Index node = 0; node < at.cols(); ++node) {
    const double mass = nodes.mass[d * node];
    momentum.head(d) += mass * nodes.velocity.segment(d * node, d);
    motion.centre += mass / motion.mass * at.col(node);
  }
  motion.velocity = one.pose.rotation * momentum / motion.mass;
  Eigen::Vector3d turning = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  for (Eigen::Index node = 0; node < at.cols(); ++node) {
    const double mass = nodes.mass[d * node];
    const Eigen::Vector3d arm = at.col(node) - motion.centre;
    Eigen::Vector3d speed = Eigen::Vector3d::Zero();
    speed.head(d) = nodes.velocity.segment(d * node, d);
    turning += mass * arm.cross(one.pose.rotation * speed);
    inertia += mass * (arm.squaredNorm() * Eigen::Matrix3d::Identity() - arm * arm.transpose());
  }
  motion.spin = inertia.inverse() * turning;
  return motion;
}

double InertiaEngine::energy() const {
  double sum = 0;
  for (int object = 0; object < world().n_objects(); ++object) {
    const auto i = static_cast<std::size_t>(object);
    const SurfaceObject& one = balance_.object(object);
    if (one.is_body()) {
      const ObjectMotion as_a_whole = motion(object);
      sum += 0.5 * nodes_[i].velocity.dot(nodes_[i].mass.cwiseProduct(nodes_[i].velocity)) -
             as_a_whole.mass * gravity_.dot(as_a_whole.centre);
      sum += one.soft->energy();
    } else if (moving_[i].has_mass) {
      sum += moving_[i].energy(one.pose) - moving_[i].mass * gravity_.dot(moving_[i].place(one.pose));
    }
  }
  return sum;
}

void InertiaEngine::move(SurfaceFrame& surfaces) {
  FrameRun& frame = surfaces.frame();
  const double seconds = frame.duration;
  const bool has_nodes =
      std::ranges::any_of(frame.drives, [](const Drive& drive) { return !drive.nodes.empty(); });
  const int n = std::max({static_cast<int>(std::ceil(seconds / longest_step - 1e-9)), 1,
                          has_nodes ? std::min(surfaces.n_steps(), 1'000'000) : 1});
  const double step = seconds / n;
  surfaces.take_handles();
  hold(step);
  balance_.hold(frame.clock.control.threads);
  bool has_settled = true;
  const bool was_apart = !balance_.crossing();
  for (int i = 0; i < n && frame.clock.has_budget() && frame.rollback_reason.empty(); ++i) {
    const Balance::State before = balance_.state();
    const bool was_still = frame.drives.empty() && is_still(step);
    fly(step);
    surfaces.drive(i, n);
    has_settled = surfaces.settle() && has_settled;
    if (surfaces.retract_blocked_drives(i, n))
      has_settled = surfaces.settle() && has_settled;
    if (was_apart)
      surfaces.restore_if_overlapping(before, i, n);
    arrive(step);
    surfaces.find_blocked(n);
    if (was_still && is_still(step))
      break;
  }
  balance_.hand_back();
  surfaces.report(has_settled);
}

} // namespace maille::deform
