#include "maille/deform/probe/device.hpp"

#include <cmath>
#include <stdexcept>

namespace maille::deform {

namespace {
constexpr int updates_of_the_hand = 16; // per tick
} // namespace

SimulatedDevice::SimulatedDevice(RecordedMotion motion, const HandModel& hand, double period)
    : motion_(std::move(motion)), hand_(hand), period_(period), position_(motion_.at(0).position) {
  for (const double value : {hand.mass, hand.damping, hand.stiffness, hand.grip})
    if (!(value >= 0) || !std::isfinite(value))
      throw std::invalid_argument("SimulatedDevice: finite numbers, none below 0");
  if (!(period > 0) || !std::isfinite(period))
    throw std::invalid_argument("SimulatedDevice: a period above 0");
  if (hand.mass > 0 && !(hand.damping > 0))
    throw std::invalid_argument("SimulatedDevice: a handle with mass has damping");
}

Pose SimulatedDevice::read() {
  if (has_begun_) {
    if (hand_.mass > 0) {
      const int parts = hand_.stiffness > 0 || hand_.grip > 0 ? updates_of_the_hand : 1;
      for (int part = 0; part < parts; ++part)
        go_on(period_ / parts);
    } else {
      time_ += period_;
    }
  }
  has_begun_ = true;
  Pose pose = motion_.at(time_);
  if (hand_.mass > 0)
    pose.position = position_;
  return pose;
}

void SimulatedDevice::go_on(double period) {
  Eigen::Vector3d force = force_;
  if (hand_.stiffness > 0 || hand_.grip > 0) {
    const Eigen::Vector3d wanted = motion_.at(time_ + period).position;
    const Eigen::Vector3d wanted_velocity = (wanted - motion_.at(time_).position) / period;
    force += hand_.stiffness * (wanted - position_) + hand_.grip * (wanted_velocity - velocity_);
  }
  // m v' = F - b v with constant F, in closed form
  const Eigen::Vector3d settled = force / hand_.damping;
  const double rate = hand_.damping / hand_.mass, decay = std::exp(-rate * period);
  const Eigen::Vector3d excess = velocity_ - settled;
  position_ += settled * period + excess * (-std::expm1(-rate * period) / rate);
  velocity_ = settled + excess * decay;
  time_ += period;
}

} // namespace maille::deform
