#pragma once
/// A world in which time passes and some objects are deformable.

#include "world/balance/surface_engine.hpp"
#include "world/dynamics/moving_object.hpp"

#include <Eigen/Core>

#include <vector>

namespace maille::deform {

/// Implicit steps (backward Euler) of everything together.
///
/// A step ends in the state of least energy as `Balance` finds it, with mass over the square of the step
/// between where each thing is and where it would have flown to: that is Newton's law with the elastic and
/// contact forces of the step's end. So nothing gains energy by a step, momentum is exchanged by equal and
/// opposite forces, and what moves fast within few steps is damped. Masses of bodies are at their nodes.
///
/// Strains are linear in the body's frame. The frame of a body that nothing holds is, after each step, the
/// turn and shift nearest to where its nodes are, so that a body may turn as far as it likes.
///
/// Checked by  tests/deform/world/soft_dynamics_test.cpp
class InertiaEngine : public SurfaceEngine {
public:
  /// @throws std::invalid_argument for a restitution: bodies rebound by their elasticity, and rigid objects
  ///         stay together
  explicit InertiaEngine(std::unique_ptr<WorldObjects> world);

  bool is_settled() const override { return false; } ///< time goes on
  ObjectMotion motion(int object) const override;
  double energy() const override;

private:
  void move(SurfaceFrame& surfaces) override;
  /// Which objects are free, and how long steps are [s]: before Balance::hold.
  void hold(double step);
  /// Predicts free flight over a step. Then Balance::prescribe and rounds.
  void fly(double step);
  /// Speeds, from where everything has come to.
  void arrive(double step);

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
  std::vector<MovingObject> moving_; ///< of rigid objects; of bodies their mass
  std::vector<Nodes> nodes_;         ///< empty of rigid objects
  std::vector<Pose> from_;           ///< of rigid objects, at the beginning of the step
};

} // namespace maille::deform
