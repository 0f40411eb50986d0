#include "maille/deform/probe/probe.hpp"

#include <algorithm>

namespace maille::deform {

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
