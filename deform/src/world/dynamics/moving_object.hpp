#pragma once
/// Rigid objects with mass, and their free flight.

#include "maille/deform/world/rigid_shape.hpp"
#include "maille/scene/world/world_scene.hpp"

#include <Eigen/Core>

namespace maille::deform {

/// Mass, inertia and velocity of a rigid object.
///
/// In two dimensions masses are for 1 m of thickness, and all rotations are about z.
struct MovingObject {
  /// @param has_mass false: driven or fixed. Poses are those of the corner of the specimen's grid
  MovingObject(const WorldObject& object, int dimension, bool has_mass);

  bool has_mass;
  double mass = 0;                                       ///< [kg]
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();      ///< of mass, in the frame of the pose [m]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Identity(); ///< about it, in that frame [kg m^2]
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();    ///< of the centre of mass [m/s]
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();        ///< [rad/s], in the world
  Eigen::Vector3d place(const Pose& pose) const { return pose.position + pose.rotation * centre; }
  Eigen::Matrix3d inertia_in_world(const Pose& pose) const {
    return pose.rotation * inertia * pose.rotation.transpose();
  }
  /// Kinetic energy [J].
  double energy(const Pose& pose) const;
};

/// Free flight: v' = gravity - damping v, and for the angular momentum, L' = -damping L.
struct Fall {
  Eigen::Vector3d gravity;
  double damping;

  /// Velocity and displacement after a time, in closed form.
  Eigen::Vector3d velocity(const Eigen::Vector3d& before, double time) const;
  Eigen::Vector3d way(const Eigen::Vector3d& before, double time) const;
  /// Advances an object in free flight. The rotation of a body that is not a sphere follows from its angular
  /// momentum, which is conserved; its energy is then conserved to second order in the angle of a step.
  void move(MovingObject& object, Pose& pose, double time) const;
};

/// Shifts an object and rotates it about its centre of mass.
Pose shifted_and_turned(const MovingObject& object, const Pose& pose, const Eigen::Vector3d& shift,
                        const Eigen::Vector3d& turn);

} // namespace maille::deform
