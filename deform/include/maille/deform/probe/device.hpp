#pragma once
/// Devices that move a probe and receive its force: the interface, simulated devices, recorded motions.

#include "maille/deform/world/rigid_shape.hpp"

#include <Eigen/Core>
#include <filesystem>
#include <string_view>
#include <vector>

namespace maille::deform {

/// Force and torque that a device renders, in the world.
struct ProbeForce {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  ///< [N]
  Eigen::Vector3d torque = Eigen::Vector3d::Zero(); ///< about the handle's point [N m]
};

/// Interface of a haptic device. One thread, that of the probe, calls all members but the destructor; it
/// calls read and write once a tick. Neither may block, or allocate if avoidable. docs/probe.md describes the
/// integration of real devices.
class ProbeDevice {
public:
  virtual ~ProbeDevice() = default;
  /// Position of the handle's point in the world [m], and its rotation.
  virtual Pose read() = 0;
  /// Sets the force until the next write.
  virtual void write(const ProbeForce& force) = 0;
  /// Physical damping of the device, isotropic [N s/m]: b in the passivity bound. Should be a conservative,
  /// small value.
  virtual double damping() const = 0;
};

/// Sampled poses of a handle. Between samples positions are linear and rotations are uniform about one axis.
class RecordedMotion {
public:
  struct Sample {
    double time = 0; ///< [s], strictly increasing
    Pose pose;       ///< of the handle's point, in the world
  };
  /// @throws std::invalid_argument without samples, or if times do not increase
  explicit RecordedMotion(std::vector<Sample> samples);

  /// Pose at a time; constant before the first and after the last sample.
  Pose at(double time) const;
  double duration() const { return samples_.back().time; }
  const std::vector<Sample>& samples() const { return samples_; }

private:
  std::vector<Sample> samples_;
};

/// Reads lines `time,x,y,z` or `time,x,y,z,turn_x,turn_y,turn_z` below a header with exactly these names:
/// seconds, metres in the world, and a rotation vector in radians. A name may be followed by another unit in
/// brackets, as in `x [mm]`. Empty lines and text after a # are ignored.
/// @throws InputError with all errors; also for a file that cannot be read, or of more than 256 MiB (device
///         files are endless)
RecordedMotion read_recorded_motion(const std::filesystem::path& file);
/// The same from text; `file` is the name in messages.
RecordedMotion parse_recorded_motion(std::string_view text, const std::string& file = "motion.csv");

/// Model of a hand that moves a handle along a recorded motion.
struct HandModel {
  double mass = 0;      ///< of handle and hand [kg]; 0: follows the recording exactly, for any force
  double damping = 0.2; ///< of the device [N s/m]
  double stiffness = 0; ///< of the hand towards the recorded place [N/m]; 0: no hand
  double grip = 0;      ///< damping of that hand, against the recorded velocity [N s/m]
};

/// Simulated device: a mass with a damper, which a hand pulls along a recorded motion and the written force
/// acts on. Every read advances time by one period, independent of the clock, so that runs are bit-identical.
///
/// Between ticks the forces of probe and hand are constant and the motion is exact, so that without a hand
/// the integration adds no energy. The hand's forces are updated sixteen times per tick.
class SimulatedDevice : public ProbeDevice {
public:
  /// @param period of the ticks [s], > 0
  /// @throws std::invalid_argument for values that are negative or not finite, or a mass without damping
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
