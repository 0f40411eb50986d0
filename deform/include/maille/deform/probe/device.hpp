#pragma once
/// What moves a probe and feels its force: devices, simulated ones, recorded motions.

#include "maille/deform/world/rigid_shape.hpp"

#include <Eigen/Core>
#include <filesystem>
#include <string_view>
#include <vector>

namespace maille::deform {

/// What a device shows to the hand, in the world.
struct ProbeForce {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  ///< [N]
  Eigen::Vector3d torque = Eigen::Vector3d::Zero(); ///< about the handle's point [N m]
};

/// A haptic device. All members but the destructor are called by one thread, the probe's, read and write once
/// a tick each: neither may block, nor ask for memory where that can be helped. docs/probe.md says how a real
/// one is plugged in.
class ProbeDevice {
public:
  virtual ~ProbeDevice() = default;
  /// Where the handle's point is in the world [m], and how it is turned.
  virtual Pose read() = 0;
  /// The force to show until the next is written.
  virtual void write(const ProbeForce& force) = 0;
  /// Mechanical damping of the device itself, the same along every direction [N s/m]: the b in the bound on
  /// passive stiffness. A cautious, small figure.
  virtual double damping() const = 0;
};

/// Poses of a handle at times; between them positions go along straight lines and turns about one axis,
/// evenly.
class RecordedMotion {
public:
  struct Sample {
    double time = 0; ///< [s], rising from sample to sample
    Pose pose;       ///< of the handle's point, in the world
  };
  /// @throws std::invalid_argument where there is no sample, or times do not rise
  explicit RecordedMotion(std::vector<Sample> samples);

  /// Before the first and after the last sample: that one.
  Pose at(double time) const;
  double duration() const { return samples_.back().time; }
  const std::vector<Sample>& samples() const { return samples_; }

private:
  std::vector<Sample> samples_;
};

/// Reads lines `time,x,y,z` or `time,x,y,z,turn_x,turn_y,turn_z` under a line with just these names: seconds,
/// metres in the world, and an axis times an angle in radians; a name may be followed by another unit in
/// brackets, as in `x [mm]`. Empty lines and what follows a # are passed over.
/// @throws InputError with every fault; a file that cannot be read, or of more than 256 MiB (a device has no
///         end)
RecordedMotion read_recorded_motion(const std::filesystem::path& file);
/// The same from text; `file` gives the name for messages.
RecordedMotion parse_recorded_motion(std::string_view text, const std::string& file = "motion.csv");

/// What moves a handle along a recorded motion.
struct HandModel {
  double mass = 0;      ///< of handle and hand [kg]; 0: the recording is followed exactly, whatever the force
  double damping = 0.2; ///< of the device [N s/m]
  double stiffness = 0; ///< of the hand that draws the handle to the recorded place [N/m]; 0: it lets go
  double grip = 0;      ///< damping of that hand, against the recorded velocity [N s/m]
};

/// A mass on a damper that a hand draws along a recorded motion and the written force acts on. Time goes on
/// by one period with every read, whatever the clock says, so that a run repeats to the bit.
///
/// Between ticks the forces of probe and hand are held and the motion under them is exact, so that without a
/// hand no energy comes from the integration; the hand's forces are brought up to date sixteen times a tick.
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
