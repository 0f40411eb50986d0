#pragma once
/// Dynamics of a world with deformable objects.

#include "world/balance/surface_engine.hpp"
#include "world/dynamics/moving_object.hpp"

#include <Eigen/Core>

#include <vector>

namespace maille::deform {

/// Implicit time steps (backward Euler) of all objects together.
///
/// A step ends in the state of least energy that `Balance` finds, with an inertial term: mass over the square
/// of the time step, on the distance from the end of free flight. This is Newton's law with the elastic and
/// contact forces at the end of the step. No step adds energy, momentum is exchanged by equal and opposite
/// forces, and motions that are fast compared with a step are damped. Masses of bodies are at their nodes.
///
/// A frame without drives skips its other steps if nothing moves before and after one: they would repeat it.
///
/// Strains are linear in the body's frame. After each step, the frame of a body without holds becomes the
/// rigid motion nearest to its node positions, so that rotations are not limited.
///
/// Checked by  tests/deform/world/soft_dynamics_test.cpp
class InertiaEngine : public SurfaceEngine {
public:
  /// @throws std::invalid_argument for a restitution: bodies rebound by their elasticity, and rigid objects
  ///         do not rebound
  explicit InertiaEngine(std::unique_ptr<WorldObjects> world);

  bool is_settled() const override { return false; } ///< time advances
  ObjectMotion motion(int object) const override;
  double energy() const override;

private:
  void move(SurfaceFrame& surfaces) override;
  /// Sets the free objects and the time step [s]. To be called before Balance::hold().
  void hold(double step);
  /// Predicts free flight over a step. To be followed by Balance::prescribe() and rounds.
  void fly(double step);
  /// Updates velocities from the new positions.
  void arrive(double step);
  /// True if nothing would move by more than `tolerance` of a cell in a step.
  bool is_still(double step) const;

  /// State of a body's components, in its frame.
  struct Nodes {
    Eigen::VectorXd mass, velocity, before;
    Eigen::Matrix3Xd rest; ///< of nodes, in the frame [m]
  };
  bool is_held(int object) const;
  Eigen::Matrix3Xd displaced(int object) const;
  /// Places of the nodes, in the world.
  Eigen::Matrix3Xd places(int object) const;
  void put_into_frame(int object, const Pose& frame);
  Pose nearest_frame(int object) const;

  Eigen::Vector3d gravity_;
  double damping_;
  std::vector<MovingObject> moving_; ///< of rigid objects; for bodies only the mass
  std::vector<Nodes> nodes_;         ///< empty for rigid objects
  std::vector<Pose> from_;           ///< of rigid objects, at the start of the step
};

} // namespace maille::deform
