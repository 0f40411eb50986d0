#pragma once
/// Rigid objects with a mass, and how they move where nothing touches them.

#include "maille/deform/world/rigid_shape.hpp"
#include "maille/scene/world/world_scene.hpp"

#include <Eigen/Core>

namespace maille::deform {

/// How a rigid object moves as a whole.
///
/// Masses are of 1 m of thickness in two dimensions, where all turns are about z.
struct MovingObject {
  /// @param pose of the corner of the specimen's grid @param has_mass false: a hand or nothing at all moves
  /// it
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

/// What moves a free object: v' = gravity - damping v, and of its turning, L' = -damping L.
struct Fall {
  Eigen::Vector3d gravity;
  double damping;

  /// Speed after a time, and the way until then, by the closed form.
  Eigen::Vector3d velocity(const Eigen::Vector3d& before, double time) const;
  Eigen::Vector3d way(const Eigen::Vector3d& before, double time) const;
  /// Goes on as nothing is in the way. The turn of a body that is not round is followed by its angular
  /// momentum, which is kept; its energy then to second order in the angle of a step.
  void move(MovingObject& object, Pose& pose, double time) const;
};

/// Shifts and turns an object about its centre of mass.
Pose shifted_and_turned(const MovingObject& object, const Pose& pose, const Eigen::Vector3d& shift,
                        const Eigen::Vector3d& turn);

} // namespace maille::deform
