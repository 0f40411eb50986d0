/// A frame of a world in which time passes.

#include "lattice/tolerances.hpp"
#include "world/balance/balance.hpp"
#include "world/dynamics/dynamics.hpp"
#include "world/world_frame.hpp"

#include <cstdint>
#include <stdexcept>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// Steps of a frame: the rest of a faster rattle is left to the next frame, and the status says so.
constexpr int most_steps = 100'000;

} // namespace

FrameResult WorldFrame::run_dynamic(double seconds) {
  if (!(seconds > 0))
    throw std::invalid_argument("World: a frame lasts longer than 0 s");
  Dynamics& dynamics = *parts_.dynamics;
  std::vector<LedObject> led;
  for (const Drive& drive : drives_) {
    if (drive.lead)
      throw std::invalid_argument("Drive: a hand that leads by a spring, in a world without dynamics");
    led.push_back({drive.object, drive.motion, parts_.balance->object(drive.object).pose});
  }
  dynamics.hold(led, seconds);
  double left = seconds;
  int steps = 0;
  Balance::State before = parts_.balance->state();
  std::vector<LedObject> led_before = led;
  const bool was_apart = !parts_.balance->crossing();
  const auto has_moved = [&] {
    for (std::size_t i = 0; i < before.objects.size(); ++i) {
      const BalancedObject& one = parts_.balance->objects()[i];
      const Pose& then = before.objects[i].pose;
      if ((one.pose.position - then.position).norm() +
              one.radius * (one.pose.rotation - then.rotation).norm() >
          round_over_cell * parts_.balance->cell())
        return true;
    }
    return false;
  };
  while (left > rounding * seconds && clock_.may_go_on() && steps < most_steps) {
    left -= dynamics.step(led, left, seconds);
    if (was_apart && has_moved()) {
      if (const auto crossing = goes_back(before, 0, 1)) {
        led = led_before;
        dynamics.stop(crossing->first);
        dynamics.stop(crossing->second);
        break;
      }
      before = parts_.balance->state();
      led_before = led;
    }
    ++steps;
    ++clock_.rounds;
    if (clock_.rounds_left)
      --*clock_.rounds_left;
  }
  parts_.balance->hand_back();
  for (const auto& [key, impulse] : dynamics.take_impulses()) {
    const auto& [object, other, node] = key;
    WorldContact contact;
    contact.object = object;
    contact.other = other;
    set_axis(contact, impulse.sum);
    contact.force = impulse.sum / seconds;
    contact.at = impulse.at;
    result_.contacts.push_back(contact);
    if (other >= 0) {
      std::swap(contact.object, contact.other);
      contact.force = -contact.force;
      contact.direction = -contact.direction;
      result_.contacts.push_back(contact);
    }
  }
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    rigid_done_[i] = led[i].done;
    report_drive(i);
    for (const WorldContact& contact : result_.contacts)
      if (contact.object == drives_[i].object)
        result_.drives[i].force -= contact.force;
  }
  report_end(!crossed_.empty() || !(left > rounding * seconds),
             "contacts came and went without end: the frame ended before its time was over",
             "the frame ended before its time was over");
  return std::move(result_);
}

} // namespace maille::deform
