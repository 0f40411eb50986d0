#include "session/hand_loop.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

namespace maille::live {

namespace {

constexpr std::int64_t period = 1'000'000; // [ns]
constexpr double period_seconds = 1e-3;

deform::Pose inverse(const deform::Pose& pose) {
  const Eigen::Matrix3d back = pose.rotation.transpose();
  return {back, -back * pose.position};
}

deform::Pose then(const deform::Pose& first, const deform::Pose& second) {
  return {second.rotation * first.rotation, second.position + second.rotation * first.position};
}

/// Pose towards the goal, as far as one tick can check; later ticks continue.
/// @param now  pose of the tool's lattice, whose centre is `half` from its corner
deform::Pose towards(const deform::Pose& goal, const deform::Pose& now, const Eigen::Vector3d& half,
                     const Vec3& cell) {
  constexpr double cells = 1.5, radians = 0.1;
  const double longest = cells * *std::ranges::min_element(cell);
  deform::Pose to = goal;
  const Eigen::Vector3d from = now.position + now.rotation * half, way = goal.position - from;
  if (way.norm() > longest)
    to.position = from + longest / way.norm() * way;
  Eigen::AngleAxisd turn(goal.rotation * now.rotation.transpose());
  if (std::abs(turn.angle()) > radians) {
    turn.angle() = std::copysign(radians, turn.angle());
    to.rotation = turn.toRotationMatrix() * now.rotation;
  }
  return to;
}

bool is_same(const deform::Pose& a, const deform::Pose& b) {
  return a.position == b.position && a.rotation == b.rotation;
}

} // namespace

HandLoop::HandLoop(Physics& physics, const SessionSettings& settings)
    : physics_(&physics), stiffness_(settings.coupling_stiffness), largest_force_(settings.largest_force),
      thread_([this] { run(); }) {}

HandLoop::~HandLoop() {
  is_stopping_ = true;
  ++bell_;
  bell_.notify_all();
  thread_.join();
}

void HandLoop::wish(const HandWish& wish) {
  HandWish numbered = wish;
  numbered.number = ++wishes_;
  wish_.publish(numbered);
  ++bell_;
  bell_.notify_one();
}

void HandLoop::use(std::shared_ptr<HandDevice> device) {
  device_.store(std::move(device));
  ++bell_;
  bell_.notify_one();
}

HandLoop::Felt HandLoop::felt() const {
  const std::lock_guard lock(felt_lock_);
  return felt_;
}

HandReport HandLoop::report() const {
  const std::lock_guard lock(felt_lock_);
  return report_;
}

void HandLoop::run() {
  const bool had_priority = deform::ServoClock::take_priority(0);
  {
    const std::lock_guard lock(felt_lock_);
    report_.had_priority = had_priority;
  }
  std::int64_t due = deform::ServoClock::now();
  while (!is_stopping_) {
    const std::uint32_t bell = bell_;
    tick();
    if (now_.grip_number == 0 && !device_.load() && is_idle()) { // the hand is open: no force
      bell_.wait(bell);
      due = deform::ServoClock::now();
      continue;
    }
    const std::int64_t done = deform::ServoClock::now();
    {
      const std::lock_guard lock(felt_lock_);
      ++report_.ticks;
      report_.latency.add(std::max<std::int64_t>(0, done - due));
    }
    due += period;
    if (const std::int64_t late = (deform::ServoClock::now() - due) / period; late > 0) {
      due += late * period;
      const std::lock_guard lock(felt_lock_);
      report_.missed += late;
    }
    deform::ServoClock::sleep_until(due);
  }
}

void HandLoop::tick() {
  take_wish();
  take_surroundings();
  const std::shared_ptr<HandDevice> device = device_.load();
  if (device) {
    device_now_ = device->read();
    move_goal(device_now_);
  }
  if (now_.grip_number != 0 &&
      (!is_same(goal_.pose, sent_) || sent_grip_ != now_.grip_number || sent_time_ != goal_.event_time)) {
    physics_->set_goal(goal_);
    sent_ = goal_.pose;
    sent_grip_ = now_.grip_number;
    sent_time_ = goal_.event_time;
  }
  wishes_done_ = now_.number;
  move_proxy();
  show_force();
  if (device)
    device->write({force_, Eigen::Vector3d::Zero()});
}

void HandLoop::take_wish() {
  if (!wish_.update())
    return;
  const std::uint64_t grip_before = now_.grip_number;
  now_ = wish_.front();
  goal_ = {now_.grip_number, now_.pose, now_.event_time, now_.axis};
  is_moved_by_device_ = false;
  if (now_.grip_number != grip_before) {
    device_before_.reset();
    proxy_.reset();
    proxy_time_ = 0;
    around_.reset();
  }
}

void HandLoop::take_surroundings() {
  if (const HandSurroundings* around = physics_->new_surroundings())
    if (around->grip_number == now_.grip_number && around->tool) {
      // The buffer keeps it alive until the next one is taken; the copy shares its parts.
      around_ = std::make_shared<const HandSurroundings>(*around);
      const bool is_clear = proxy_ && around_->others.matter->n_inside(*around_->tool, proxy_->pose()) == 0;
      if (!is_clear) { // the proxy overlaps: reset it to the tool of the physics
        deform::Pose middle = around_->lattice;
        middle.position += middle.rotation * around_->tool->middle();
        proxy_.emplace(*around_->tool, middle);
      }
    }
}

/// A position device moves the goal by its own motion; a rate device moves it with its velocity.
void HandLoop::move_goal(const DeviceState& device) {
  if (!device.is_there || now_.grip_number == 0) {
    device_before_.reset();
    return;
  }
  if (device.pose) {
    if (device_before_) {
      is_moved_by_device_ |= !is_same(*device.pose, *device_before_);
      goal_.pose.position += device.pose->position - device_before_->position;
      goal_.pose.rotation =
          device.pose->rotation * device_before_->rotation.transpose() * goal_.pose.rotation;
    }
    device_before_ = device.pose;
    return;
  }
  is_moved_by_device_ |= !device.velocity.isZero(0) || !device.turning.isZero(0);
  goal_.pose.position += period_seconds * device.velocity;
  const double angle = period_seconds * device.turning.norm();
  if (angle > 0)
    goal_.pose.rotation =
        Eigen::AngleAxisd(angle, device.turning.normalized()).toRotationMatrix() * goal_.pose.rotation;
}

void HandLoop::move_proxy() {
  if (!proxy_ || !around_ || --proxy_pause_ > 0)
    return;
  const std::int64_t began = deform::ServoClock::now();
  // Centre of the tool when the frame is at the goal.
  const deform::Pose lattice = then(then(around_->lattice, inverse(around_->frame)), goal_.pose);
  const Eigen::Vector3d half = around_->tool->middle();
  const deform::Pose goal{lattice.rotation, lattice.position + lattice.rotation * half};
  proxy_->follow(*around_->others.matter,
                 towards(goal, proxy_->pose(), half, around_->others.matter->cell_size()));
  proxy_time_ = goal_.event_time;
  proxy_pause_ = 1 + 2 * (deform::ServoClock::now() - began) / period;
}

void HandLoop::show_force() {
  Felt felt;
  felt.grip_number = now_.grip_number;
  felt.goal = goal_.pose;
  felt.device = device_now_;
  felt.is_moved_by_device = is_moved_by_device_;
  felt.event_time = proxy_time_;
  force_.setZero();
  if (proxy_ && around_) {
    // Frame of the object when its lattice is at the proxy.
    const deform::Pose lattice_in_frame = then(around_->lattice, inverse(around_->frame));
    const deform::Pose back = inverse(lattice_in_frame);
    felt.proxy = deform::Pose{proxy_->pose().rotation * back.rotation,
                              proxy_->pose().position + proxy_->pose().rotation * back.position};
    force_ = stiffness_ * (felt.proxy->position - goal_.pose.position);
  } else if (now_.grip_number != 0) {
    force_ = -physics_->state()->hand_force;
  }
  if (force_.norm() > largest_force_)
    force_ *= largest_force_ / force_.norm();
  felt.force = force_;
  const std::lock_guard lock(felt_lock_);
  felt_ = felt;
}

} // namespace maille::live
