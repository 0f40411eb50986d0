/// The force of a probe at one tick: proxy, contact stiffness, coupling, passivity.
///
/// Scheme: the proxy (Proxy) follows the device without entering rigid cells or bodies at rest. The depth of
/// the device below it is shared between the coupling spring K_c and the body's stiffness K in series: force
/// = depth K K_c / (K + K_c). Other threads solve for K (ContactSolver); changes of K are blended in, and an
/// estimate is used before the first answer. A body's own reaction may replace the coupling
/// (ForceRule::reaction) if it is passive: at most `passive_share` of the bound b > K T / 2 + |B|.
///
/// Exact: the passivity bound for a spring and damper (Colgate and Brown 1994), and the places of the proxy.
/// Heuristic: the criterion for a new site, the time ahead for solves, blending and easing.

#include "maille/deform/probe/probe.hpp"

#include "lattice/tolerances.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace maille::deform {

namespace {

/// Largest reaction stiffness of a body, as a share of the largest passive stiffness.
constexpr double passive_share = 0.9;
/// Relative change of depth that makes a site a new one, if the stiffness depends on depth.
constexpr double depth_change = 0.25;
/// Prediction time of a free tool, and interval of predictions [s]: an answer of a body takes a tenth of a
/// second.
constexpr double time_ahead = 0.4, time_between_looks = 0.016;
/// Depth to which a body is solved ahead of contact, in units of its skin.
constexpr double depth_ahead_over_skin = step_over_cell / negligible;

double in_a_row(double a, double b) {
  return std::isinf(b) ? a : a * b / (a + b);
}

} // namespace

Probe::Probe(std::shared_ptr<const Surroundings> surroundings, Proxy proxy, const ProbeSettings& settings,
             double device_damping)
    : surroundings_(std::move(surroundings)), proxy_(std::move(proxy)), settings_(settings),
      observer_(device_damping, settings.period, device_damping),
      most_passive_(largest_passive_stiffness(device_damping, settings.coupling.damping, settings.period)),
      bodies_(static_cast<std::size_t>(surroundings_->n_bodies())) {
  const CouplingSettings& coupling = settings.coupling;
  if (!(settings.period > 0) || !(coupling.stiffness > 0) || !(coupling.damping >= 0) ||
      !(coupling.turn_stiffness >= 0) || !(settings.blending >= 0) || !(settings.easing >= 0) ||
      !(settings.largest_force > 0))
    throw std::invalid_argument(
        "Probe: period, stiffness and largest force above 0, damping, blending and easing not below");
  if (!is_passive(coupling, device_damping, settings.period))
    throw std::invalid_argument("Probe: a coupling that is passive: stiffness < 2 (b - damping) / period");
  device_.position = proxy_.middle();
}

void Probe::link(int body, BodyLink link) {
  Body& linked = bodies_.at(static_cast<std::size_t>(body));
  linked.link = std::move(link);
  linked.stiffness = linked.link.newest().stiffness;
}

void Probe::link(int body, ContactPhysics& physics, bool depends_on_depth) {
  link(body, {[&physics](const ContactSite& site) { physics.ask(site); },
              [&physics]() -> const ContactStiffness& { return physics.newest(); }, depends_on_depth});
}

double Probe::felt(double body_stiffness) const {
  if (settings_.rule == ForceRule::reaction && body_stiffness < passive_share * most_passive_)
    return body_stiffness;
  return in_a_row(settings_.coupling.stiffness, body_stiffness);
}

void Probe::ask(Body& body, const Obstacle& obstacle, double depth, const Pose& tool) {
  body.site = {++n_sites_, obstacle.face, obstacle.point, depth, std::nullopt};
  if (proxy_.tool().n_voxels() > 1)
    body.site.tool = tool;
  body.link.ask(body.site);
}

void Probe::look_ahead(const Eigen::Vector3d& way) {
  RigidMotion motion;
  motion.by = time_ahead / settings_.period * way;
  Pose pose = proxy_.pose();
  double done = 0;
  const auto obstacle = surroundings_->move(proxy_.tool(), motion, pose, done);
  if (!obstacle || obstacle->body < 0)
    return;
  Body& body = bodies_[obstacle->body];
  if (!body.link.ask || obstacle->face < 0 || obstacle->face == body.site.face)
    return;
  ask(body, *obstacle, depth_ahead_over_skin * surroundings_->body(obstacle->body).skin(), pose);
}

double Probe::update(Body& body, const Constraint& constraint) {
  if (!body.link.ask)
    return std::numeric_limits<double>::infinity(); // stiffness not known yet: rigid
  const double given_way = constraint.depth * felt(body.stiffness) / body.stiffness;
  const double least = surroundings_->body(constraint.obstacle.body).skin();
  const bool is_elsewhere = constraint.obstacle.face != body.site.face;
  const bool may_depend = body.link.depends_on_depth || proxy_.tool().n_voxels() > 1; // more contacts
  const bool is_deeper = may_depend && std::abs(given_way - body.site.depth) > depth_change * body.site.depth;
  if ((is_elsewhere || is_deeper) && given_way > least)
    ask(body, constraint.obstacle, given_way, proxy_.pose());
  const double newest = body.link.newest().stiffness;
  if (std::isinf(newest) || std::isinf(body.stiffness) || !body.was_touched)
    body.stiffness = newest;
  else
    body.stiffness +=
        (newest - body.stiffness) * -std::expm1(-settings_.period / std::max(settings_.blending, 1e-9));
  return body.stiffness;
}

Eigen::Vector3d Probe::force_of_constraints() {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  for (const Constraint& constraint : proxy_.constraints()) {
    if (!(constraint.depth > 0))
      continue;
    state_.is_touching = true;
    double stiffness = settings_.coupling.stiffness;
    if (constraint.obstacle.body >= 0) {
      Body& body = bodies_[constraint.obstacle.body];
      const double of_body = update(body, constraint);
      stiffness = felt(of_body);
      const double share = std::isinf(of_body) ? 0 : stiffness / of_body;
      state_.body = constraint.obstacle.body;
      state_.stiffness = of_body;
      state_.depth = std::max(state_.depth, share * constraint.depth);
      state_.proxy -= share * constraint.depth * constraint.obstacle.normal;
    }
    force += stiffness * constraint.depth * constraint.obstacle.normal;
  }
  return force;
}

/// In convex free space the place nearest to the device never moves further than the device. Excess motion
/// means that the proxy came off a step of rigid cells; it is eased.
const Eigen::Vector3d& Probe::eased(const Eigen::Vector3d& hand_way, const Eigen::Vector3d& proxy_way) {
  const bool on_rigid = state_.is_touching && state_.body < 0;
  if (!on_rigid || !was_touching_ || settings_.easing == 0) {
    behind_.setZero();
    return behind_;
  }
  behind_ *= std::exp(-settings_.period / settings_.easing);
  const double length = proxy_way.norm(), more = length - hand_way.norm();
  if (more > 0)
    behind_ -= more / length * proxy_way;
  return behind_;
}

Eigen::Vector3d Probe::torque() const {
  if (settings_.coupling.turn_stiffness == 0 || proxy_.tool().n_voxels() == 1)
    return Eigen::Vector3d::Zero();
  const Eigen::AngleAxisd turn(proxy_.pose().rotation * device_.rotation.transpose());
  return settings_.coupling.turn_stiffness * turn.angle() * turn.axis();
}

const ProbeState& Probe::tick(const Pose& device) {
  const Eigen::Vector3d before = device_.position, proxy_before = proxy_.middle();
  if (device.position.allFinite() && device.rotation.allFinite())
    device_ = device;
  if (const OccupancyMap* map = surroundings_->map(); map != nullptr && map->cells()[2] == 1)
    device_.position[2] = proxy_.middle()[2]; // in two dimensions
  proxy_.follow(*surroundings_, device_);
  state_ = {};
  state_.device = device_.position;
  state_.proxy = proxy_.middle();
  Eigen::Vector3d force = force_of_constraints();
  force += settings_.coupling.stiffness * eased(device_.position - before, proxy_.middle() - proxy_before);
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    bodies_[i].was_touched = state_.is_touching && state_.body == static_cast<int>(i);
  if (--ticks_to_look_ <= 0 && !state_.is_touching && !bodies_.empty() &&
      device_.position != before) { // the stiffness is then known at first contact
    look_ahead(device_.position - before);
    ticks_to_look_ = static_cast<int>(std::ceil(time_between_looks / settings_.period));
  }
  const Eigen::Vector3d spring = proxy_.middle() + behind_ - device_.position;
  if (state_.is_touching && was_touching_ && settings_.coupling.damping > 0) {
    // The damper force never exceeds the spring force, so that it never pulls into the wall.
    const double along = spring.norm();
    const double rate = along > 0 ? spring.dot(spring - spring_) / (along * settings_.period) : 0;
    const double most = force.norm();
    if (along > 0)
      force += std::clamp(settings_.coupling.damping * rate, -most, most) * spring / along;
  }
  spring_ = spring;
  was_touching_ = state_.is_touching;
  if (const double size = force.norm(); size > settings_.largest_force)
    force *= settings_.largest_force / size;
  state_.force.force = settings_.guard ? observer_.guarded(device_.position, force)
                                       : observer_.watched(device_.position, force);
  state_.force.torque = torque();
  return state_;
}

double largest_passive_stiffness(double device_damping, double damping, double period) {
  return std::max(0.0, 2 * (device_damping - damping) / period);
}

const Eigen::Vector3d& PassivityObserver::watched(const Eigen::Vector3d& position,
                                                  const Eigen::Vector3d& force) {
  const Eigen::Vector3d gone = has_begun_ ? Eigen::Vector3d(position - position_) : Eigen::Vector3d::Zero();
  velocity_ = gone / period_;
  energy_ += device_damping_ * velocity_.squaredNorm() * period_ - force_.dot(gone);
  least_energy_ = std::min(least_energy_, energy_);
  taken_back_ += added_damping_ * velocity_.squaredNorm() * period_;
  position_ = position;
  has_begun_ = true;
  added_damping_ = 0;
  force_ = force;
  return force_;
}

Eigen::Vector3d PassivityObserver::guarded(const Eigen::Vector3d& position, const Eigen::Vector3d& force) {
  watched(position, force);
  const double speed_2 = velocity_.squaredNorm();
  if (energy_ < 0 && speed_2 > 0)
    added_damping_ = std::min(-energy_ / (speed_2 * period_), most_damping_);
  force_ -= added_damping_ * velocity_;
  return force_;
}

} // namespace maille::deform
