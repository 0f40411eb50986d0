#include "maille/live/device.hpp"

#include <cmath>
#include <map>
#include <memory>
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

/// Written by the window thread, read by the hand thread; locked only to copy a few numbers.
struct GamePad::Axes {
  std::mutex lock;
  std::map<std::string, double> of;
  bool is_there = false, was_lost = false;
};

std::shared_ptr<GamePad::Axes> GamePad::make_axes() {
  return std::make_shared<Axes>();
}

GamePad::~GamePad() = default;

void GamePad::set(const std::string& axis, double value) {
  const std::lock_guard lock(axes_->lock);
  axes_->of[axis] = std::isfinite(value) ? value : 0;
  axes_->is_there = true;
}

void GamePad::lose() {
  const std::lock_guard lock(axes_->lock);
  axes_->of.clear();
  axes_->is_there = false;
  axes_->was_lost = true;
}

DeviceState GamePad::read() {
  const std::lock_guard lock(axes_->lock);
  const auto axis = [this](const char* name) {
    const auto found = axes_->of.find(name);
    return found == axes_->of.end() ? 0.0 : outside_dead_zone(found->second);
  };
  DeviceState state;
  state.is_there = axes_->is_there;
  state.velocity =
      speed_ * Eigen::Vector3d(axis("leftx"), -axis("lefty"), axis("triggerright") - axis("triggerleft"));
  state.turning = radians_a_second * Eigen::Vector3d(axis("righty"), axis("rightx"), 0);
  state.buttons = axis("a") > 0.5 ? 1 : 0;
  return state;
}

std::string GamePad::status() const {
  const std::lock_guard lock(axes_->lock);
  return axes_->is_there   ? "game controller"
         : axes_->was_lost ? "game controller: lost; what it held stays where it is"
                           : "game controller: waiting for one";
}

} // namespace maille::live
