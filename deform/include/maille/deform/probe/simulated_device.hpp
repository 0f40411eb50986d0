#pragma once
/// A device that is not there.

#include "maille/deform/probe/device.hpp"
#include "maille/deform/probe/recorded_motion.hpp"

namespace maille::deform {

/// What moves a handle along a recorded motion.
struct HandModel {
  double mass = 0;      ///< of handle and hand [kg]; 0: the recording is followed exactly, whatever the force
  double damping = 0.2; ///< of the device [N s/m]
  double stiffness = 0; ///< of the hand that draws the handle to the recorded place [N/m]; 0: it lets go
  double grip = 0;      ///< damping of that hand, against the recorded velocity [N s/m]
};

/// A mass on a damper that a hand draws along a recorded motion and the written force acts on. Time goes on by one period with every
/// read, whatever the clock says, so that a run repeats to the bit.
///
/// Between ticks the forces of probe and hand are held and the motion under them is exact, so that without a hand no energy comes from the
/// integration; the hand's forces are brought up to date sixteen times a tick.
class SimulatedDevice : public ProbeDevice {
public:
  /// @param period of the ticks [s], > 0
  /// @throws std::invalid_argument for what is negative or not finite, or a mass without any damping
  SimulatedDevice(RecordedMotion motion, const HandModel& hand, double period);

  Pose read() override;
  void write(const ProbeForce& force) override { force_ = force.force; }
  double damping() const override { return hand_.damping; }

  double time() const { return time_; } ///< of the last read [s]
  const Eigen::Vector3d& velocity() const { return velocity_; }
  void set_velocity(const Eigen::Vector3d& velocity) { velocity_ = velocity; }
  double kinetic_energy() const { return 0.5 * hand_.mass * velocity_.squaredNorm(); }

private:
  void go_on(double period);

  RecordedMotion motion_;
  HandModel hand_;
  double period_;
  bool has_begun_ = false;
  double time_ = 0;
  Eigen::Vector3d position_, velocity_ = Eigen::Vector3d::Zero(), force_ = Eigen::Vector3d::Zero();
};

} // namespace maille::deform
