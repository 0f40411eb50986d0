#include "world/dynamics/impact_engine.hpp"

#include "lattice/tolerances.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// Largest number of steps of a frame: faster chatter is left to the next frame, and reported in the status.
constexpr int most_steps = 100'000;

} // namespace

ImpactEngine::ImpactEngine(std::unique_ptr<WorldObjects> of)
    : SurfaceEngine(std::move(of)), fall_{Eigen::Vector3d::Map(world().scene.dynamics->gravity.data()),
                                          world().scene.dynamics->damping},
      restitution_(world().scene.dynamics->restitution) {
  for (int object = 0; object < world().n_objects(); ++object)
    moving_.emplace_back(world().object(object), world().scene.dimension,
                         world().member(object).kind == ObjectKind::rigid);
}

double ImpactEngine::skin() const {
  return skin_over_cell * balance_.cell();
}

ImpactEngine::State ImpactEngine::state() const {
  State now{{}, moving_};
  for (const SurfaceObject& one : balance_.objects())
    now.poses.push_back(one.pose);
  return now;
}

void ImpactEngine::put(const State& state) {
  moving_ = state.moving;
  for (int object = 0; object < world().n_objects(); ++object) {
    SurfaceObject& one = balance_.object(object);
    one.pose = state.poses[object];
    if (one.kind != ObjectKind::fixed)
      one.place();
  }
}

double ImpactEngine::look() {
  balance_.find_touches();
  return least_gap();
}

double ImpactEngine::least_gap() const {
  double least = std::numeric_limits<double>::infinity();
  for (const Touch& touch : balance_.touches())
    if (moving_[touch.object].has_mass || (touch.other >= 0 && moving_[touch.other].has_mass) ||
        world().member(touch.object).is_driven || (touch.other >= 0 && world().member(touch.other).is_driven))
      least = std::min(least, touch.gap);
  return least;
}

void ImpactEngine::hold(std::span<LedObject> led, double seconds) {
  look();
  for (int object = 0; object < world().n_objects(); ++object) {
    MovingObject& one = moving_[object];
    one.has_mass = world().member(object).kind == ObjectKind::rigid && !world().member(object).is_driven;
    if (!one.has_mass)
      one.velocity = one.spin = Eigen::Vector3d::Zero();
  }
  for (const LedObject& drive : led) {
    MovingObject& one = moving_[drive.object];
    one.spin += drive.motion.angle / seconds * drive.motion.axis;
    one.velocity += drive.motion.by / seconds + one.spin.cross(one.place(drive.from) - drive.motion.about);
  }
}

void ImpactEngine::stop(int object) {
  MovingObject& one = moving_[object];
  one.velocity = one.spin = Eigen::Vector3d::Zero();
}

std::vector<ImpactPoint> ImpactEngine::points(double within) const {
  std::vector<ImpactPoint> list;
  for (const Touch& touch : balance_.touches()) {
    if (touch.gap > within)
      continue;
    ImpactPoint point;
    point.object = touch.object;
    point.other = touch.other;
    point.node = touch.node;
    point.at = balance_.object(touch.object).at[touch.node];
    point.normal = touch.normal;
    point.gap = touch.gap;
    if (point.other > point.object) { // each pair in one order
      std::swap(point.object, point.other);
      point.normal = -point.normal;
    }
    list.push_back(point);
  }
  std::ranges::stable_sort(list, {}, [](const ImpactPoint& p) { return std::pair(p.object, p.other); });
  return carriers_of(list);
}

void ImpactEngine::keep(std::span<const ImpactPoint> points) {
  for (const ImpactPoint& point : points)
    if (point.impulse != 0) {
      Impulse& known = impulses_[{point.object, point.other, point.node}];
      known.sum += point.impulse * point.normal;
      known.at = point.at;
    }
}

/// Applies impulses. Objects jammed between drives and walls stop the drives.
void ImpactEngine::resolve(std::span<ImpactPoint> points, std::vector<MovingObject>& moving,
                           double restitution, std::span<LedObject> led) {
  std::vector<Pose> poses;
  for (const SurfaceObject& one : balance_.objects())
    poses.push_back(one.pose);
  const double left = resolve_impacts(points, poses, moving, restitution);
  if (left > 0) {
    for (LedObject& drive : led) {
      drive.is_stopped = true;
      stop(drive.object);
      moving[drive.object] = moving_[drive.object];
    }
    resolve_impacts(points, poses, moving, 0);
  }
  keep(points);
}

double ImpactEngine::longest_step(double most) const {
  const double way = round_over_cell * balance_.cell();
  double step = most;
  for (int object = 0; object < world().n_objects(); ++object) {
    const MovingObject& one = moving_[object];
    const double radius = balance_.object(object).rigid.radius();
    const double speed = one.velocity.norm() + 2 * radius * one.spin.norm(),
                 gravity = one.has_mass ? fall_.gravity.norm() : 0;
    // speed t + gravity t^2 / 2 = way
    const double t = 2 * way / (speed + std::sqrt(speed * speed + 2 * gravity * way));
    step = std::min(step, t);
  }
  return step;
}

ImpactEngine::State ImpactEngine::moved(const State& from, std::span<const char> lies,
                                        std::span<const LedObject> led, double time, double seconds) const {
  State to = from;
  for (std::size_t i = 0; i < to.moving.size(); ++i) {
    MovingObject& one = to.moving[i];
    if (!one.has_mass)
      continue;
    if (lies[i] != 0)
      Fall{Eigen::Vector3d::Zero(), 0}.move(one, to.poses[i], time);
    else
      fall_.move(one, to.poses[i], time);
  }
  for (const LedObject& drive : led)
    to.poses[drive.object] =
        drive.motion.moved(drive.from, std::min(1.0, drive.done + (drive.is_stopped ? 0 : time / seconds)));
  return to;
}

/// Separates objects with small overlaps; velocities do not change.
void ImpactEngine::part_overlaps() {
  std::vector<ImpactPoint> inside = points(-0.25 * skin());
  if (inside.empty())
    return;
  State now = state();
  std::vector<MovingObject> still = now.moving;
  for (MovingObject& one : still)
    one.velocity = one.spin = Eigen::Vector3d::Zero();
  for (ImpactPoint& point : inside)
    point.lead = -point.gap; // within a unit of time
  resolve_impacts(inside, now.poses, still, 0);
  for (std::size_t i = 0; i < still.size(); ++i)
    if (still[i].has_mass)
      now.poses[i] = shifted_and_turned(still[i], now.poses[i], still[i].velocity, still[i].spin);
  put(now);
  look();
}

double ImpactEngine::step(std::span<LedObject> led, double most, double seconds) {
  double gap = least_gap();
  std::vector<ImpactPoint> touching = points(skin());
  resolve(touching, moving_, restitution_, led);
  const double longest = longest_step(most);
  // Objects that gravity presses together are resting.
  std::vector<MovingObject> falling = moving_;
  for (MovingObject& one : falling)
    if (one.has_mass)
      one.velocity = fall_.velocity(one.velocity, longest);
  const std::vector<MovingObject> free = falling;
  touching = points(skin());
  resolve(touching, falling, 0, led);
  std::vector<char> lies(moving_.size(), 0);
  for (std::size_t i = 0; i < moving_.size(); ++i)
    if (falling[i].has_mass && (falling[i].velocity != free[i].velocity || falling[i].spin != free[i].spin)) {
      lies[i] = 1;
      moving_[i] = falling[i];
    }
  const State before = state();
  double low = 0, high = longest, time = longest;
  put(moved(before, lies, led, time, seconds));
  if (double beyond = look(); beyond < -skin()) {
    // The smallest gap of a pair is nearly linear in time. With other resting contacts, it has no information
    // on the free side: then two times with overlap define the line.
    double later = high, deeper = beyond;
    for (int trial = 0; trial < iteration_cap; ++trial) {
      time = 0.5 * (low + high);
      if (const double guess = gap > skin() ? low + (high - low) * gap / (gap - beyond)
                                            : high - beyond * (later - high) / (deeper - beyond);
          trial % 3 != 2 && guess > low && guess < high)
        time = guess;
      put(moved(before, lies, led, time, seconds));
      const double now = look();
      if (std::abs(now) < 0.5 * skin())
        break;
      if (now > 0) {
        low = time;
        gap = now;
      } else {
        later = std::exchange(high, time);
        deeper = std::exchange(beyond, now);
      }
    }
    if (time < tolerance * longest) { // corners that rotate into their support
      time = longest;
      put(moved(before, lies, led, time, seconds));
      look();
      part_overlaps();
    }
  }
  for (LedObject& drive : led)
    if (!drive.is_stopped)
      drive.done += time / seconds;
  return time;
}

double ImpactEngine::energy() const {
  double sum = 0;
  for (std::size_t i = 0; i < moving_.size(); ++i)
    if (moving_[i].has_mass) {
      const Pose& pose = balance_.objects()[i].pose;
      sum += moving_[i].energy(pose) - moving_[i].mass * fall_.gravity.dot(moving_[i].place(pose));
    }
  return sum;
}

ObjectMotion ImpactEngine::motion(int object) const {
  const MovingObject& one = moving_[object];
  return {one.mass, one.velocity, one.spin, one.place(balance_.object(object).pose)};
}

/// True if an object has moved so far that it may overlap another.
bool ImpactEngine::has_moved(const Balance::State& since) const {
  for (std::size_t i = 0; i < since.objects.size(); ++i) {
    const SurfaceObject& one = balance_.objects()[i];
    const Pose& then = since.objects[i].pose;
    if ((one.pose.position - then.position).norm() +
            one.rigid.radius() * (one.pose.rotation - then.rotation).norm() >
        round_over_cell * balance_.cell())
      return true;
  }
  return false;
}

void ImpactEngine::move(SurfaceFrame& surfaces) {
  FrameRun& frame = surfaces.frame();
  const double seconds = frame.duration;
  std::vector<LedObject> led;
  for (const Drive& drive : frame.drives)
    led.push_back({drive.object, drive.motion, balance_.object(drive.object).pose});
  hold(led, seconds);
  impulses_.clear();
  double left = seconds;
  Balance::State before = balance_.state();
  std::vector<LedObject> led_before = led;
  const bool was_apart = !balance_.crossing();
  for (int steps = 0; left > rounding * seconds && frame.clock.has_budget() && steps < most_steps; ++steps) {
    left -= step(led, left, seconds);
    if (was_apart && has_moved(before)) {
      if (const auto crossing = surfaces.restore_if_overlapping(before, 0, 1)) {
        led = led_before;
        stop(crossing->first);
        stop(crossing->second);
        break;
      }
      before = balance_.state();
      led_before = led;
    }
    frame.clock.count_round();
  }
  balance_.hand_back();
  report(frame, led);
  frame.report_end(!frame.rollback_reason.empty() || !(left > rounding * seconds),
                   "contacts came and went without end: the frame ended before its time was over",
                   "the frame ended before its time was over");
}

void ImpactEngine::report(FrameRun& frame, std::span<const LedObject> led) {
  std::vector<WorldContact>& contacts = frame.result.contacts;
  for (const auto& [key, impulse] : impulses_) {
    WorldContact contact;
    contact.object = std::get<0>(key);
    contact.other = std::get<1>(key);
    set_axis(contact, impulse.sum);
    contact.force = impulse.sum / frame.duration;
    contact.at = impulse.at;
    contacts.push_back(contact);
    if (contact.other >= 0) {
      std::swap(contact.object, contact.other);
      contact.force = -contact.force;
      contact.direction = -contact.direction;
      contacts.push_back(contact);
    }
  }
  for (std::size_t i = 0; i < led.size(); ++i)
    frame.done[i] = led[i].done;
  frame.report_drives();
  for (std::size_t i = 0; i < led.size(); ++i)
    for (const WorldContact& contact : contacts)
      if (contact.object == led[i].object)
        frame.result.drives[i].force -= contact.force;
}

} // namespace maille::deform
