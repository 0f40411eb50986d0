#pragma once
/// Whether a probe can give more energy to a hand than the hand gave to it.

#include <Eigen/Core>

namespace maille::deform {

/// A sampled, held spring and damper that a device shows to a hand.
struct CouplingSettings {
  double stiffness = 300;    ///< [N/m], > 0
  double damping = 0;        ///< [N s/m], >= 0
  double turn_stiffness = 0; ///< [N m/rad], >= 0; of tools of several voxels
};

/// The stiffest spring that no hand can draw energy from: 2 (b - B) / T, or 0 where there is none [N/m].
///
/// @param device_damping of the device itself, not computed [N s/m] @param damping of the coupling [N s/m], >= 0 @param period between
/// forces [s], > 0
/// Source      Colgate and Brown 1994 (ICRA), "Factors affecting the Z-width of a haptic display": b > K T / 2 + |B|, for walls of a
///             spring and a damper with backward differences
double largest_passive_stiffness(double device_damping, double damping, double period);

/// Whether the coupling keeps to that bound, strictly.
inline bool is_passive(const CouplingSettings& coupling, double device_damping, double period) {
  return coupling.stiffness < largest_passive_stiffness(device_damping, coupling.damping, period);
}

/// The energy that has gone from the hand into the probe, tick by tick, exactly: forces are held between ticks, so what a force does is
/// its product with the distance gone.
///
/// It is at least 0 at all times where the probe is passive. The bound above is for one spring; springs that change while they are
/// pressed, as those of a body do whose stiffness becomes known, may break it. Then the force gets what damping takes the excess back.
///
/// Source      Hannaford and Ryu 2002 (IEEE Trans. Robotics and Automation 18), "Time-domain passivity control of haptic interfaces",
///             equations 6 and 11. Departure: what the device's own damping takes is counted, as it is what the bound relies on.
class PassivityObserver {
public:
  /// @param device_damping [N s/m] @param period [s] @param most_damping that is ever added [N s/m]
  PassivityObserver(double device_damping, double period, double most_damping)
      : device_damping_(device_damping), period_(period), most_damping_(most_damping) {}

  /// @param position of the device now [m] @param force that is to be shown from now on [N] @return the force to show
  Eigen::Vector3d guarded(const Eigen::Vector3d& position, const Eigen::Vector3d& force);
  /// Counts only. @return the force as it is
  const Eigen::Vector3d& watched(const Eigen::Vector3d& position, const Eigen::Vector3d& force);

  double energy() const { return energy_; }             ///< from the hand into probe and device [J]
  double least_energy() const { return least_energy_; } ///< so far [J], <= 0
  double taken_back() const { return taken_back_; }     ///< by added damping [J]

private:
  double device_damping_, period_, most_damping_;
  bool has_begun_ = false;
  Eigen::Vector3d position_ = Eigen::Vector3d::Zero(), force_ = Eigen::Vector3d::Zero(),
                  velocity_ = Eigen::Vector3d::Zero();
  double added_damping_ = 0;
  double energy_ = 0, least_energy_ = 0, taken_back_ = 0;
};

} // namespace maille::deform
