/// A frame of a world in which time passes.

#include "world/balance/balance.hpp"
#include "world/dynamics/dynamics.hpp"
#include "world/world_frame.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <fmt/format.h>
#include <stdexcept>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

constexpr double missed = 1e-6;
/// Of a frame: shorter is the rounding of times that are added up.
constexpr double no_time = 1e-12;
constexpr int most_steps = 100'000; ///< of a frame: what rattles so fast is left to the next

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
  while (left > no_time * seconds && clock_.may_go_on() && steps < most_steps) {
    left -= dynamics.step(led, left, seconds);
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
    Eigen::Index axis = 0;
    impulse.sum.cwiseAbs().maxCoeff(&axis);
    contact.axis = static_cast<int>(axis);
    contact.direction = impulse.sum[axis] > 0 ? -1 : 1;
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
  result_.rounds = clock_.rounds;
  const auto cut = std::ranges::find_if(result_.drives,
                                        [](const DriveResult& drive) { return drive.fraction < 1 - missed; });
  if (clock_.ended) {
    result_.status = *clock_.ended;
    result_.message = "the frame ended before its time was over";
  } else if (left > no_time * seconds) {
    result_.status = Status::budget_reached;
    result_.message = "contacts came and went without end: the frame ended before its time was over";
  } else if (cut != result_.drives.end()) {
    result_.status = Status::clamped;
    result_.message = fmt::format(
        "object `{}` came {:.3g} % of its way",
        name(drives_[static_cast<std::size_t>(cut - result_.drives.begin())].object), 100 * cut->fraction);
  }
  result_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  return std::move(result_);
}

} // namespace maille::deform
