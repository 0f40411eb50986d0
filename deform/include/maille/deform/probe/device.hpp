#pragma once
/// What a hand holds: read for where it is, told what force to show.

#include "maille/deform/world/rigid_shape.hpp"

#include <Eigen/Core>

namespace maille::deform {

/// What a device shows to the hand, in the world.
struct ProbeForce {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  ///< [N]
  Eigen::Vector3d torque = Eigen::Vector3d::Zero(); ///< about the handle's point [N m]
};

/// A haptic device. All members but the destructor are called by one thread, the probe's, read and write once a tick each: neither may
/// block, nor ask for memory where that can be helped. docs/probe.md says how a real one is plugged in.
class ProbeDevice {
public:
  virtual ~ProbeDevice() = default;
  /// Where the handle's point is in the world [m], and how it is turned.
  virtual Pose read() = 0;
  /// The force to show until the next is written.
  virtual void write(const ProbeForce& force) = 0;
  /// Of the device's own mechanics, along any direction [N s/m]: the b that passivity rests on. A cautious, small figure.
  virtual double damping() const = 0;
};

} // namespace maille::deform
