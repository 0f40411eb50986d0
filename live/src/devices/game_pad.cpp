#include "maille/live/device.hpp"

#include <cmath>
#include <mutex>
#include <string>

namespace maille::live {

namespace {

constexpr double dead_zone = 0.12;
constexpr double radians_a_second = 1.5;

double outside_dead_zone(double value) {
  const double size = std::abs(value);
  return size < dead_zone ? 0 : std::copysign((size - dead_zone) / (1 - dead_zone), value);
}

} // namespace

void GamePad::set(const std::string& axis, double value) {
  const std::lock_guard lock(lock_);
  axes_[axis] = std::isfinite(value) ? value : 0;
  is_there_ = true;
}

void GamePad::lose() {
  const std::lock_guard lock(lock_);
  axes_.clear();
  is_there_ = false;
  was_lost_ = true;
}

DeviceState GamePad::read() {
  const std::lock_guard lock(lock_);
  const auto axis = [this](const char* name) {
    const auto found = axes_.find(name);
    return found == axes_.end() ? 0.0 : outside_dead_zone(found->second);
  };
  DeviceState state;
  state.is_there = is_there_;
  state.velocity =
      speed_ * Eigen::Vector3d(axis("leftx"), -axis("lefty"), axis("triggerright") - axis("triggerleft"));
  state.turning = radians_a_second * Eigen::Vector3d(axis("righty"), axis("rightx"), 0);
  state.buttons = axis("a") > 0.5 ? 1 : 0;
  return state;
}

std::string GamePad::status() const {
  const std::lock_guard lock(lock_);
  return is_there_   ? "game controller"
         : was_lost_ ? "game controller: lost; what it held stays where it is"
                     : "game controller: waiting for one";
}

} // namespace maille::live
