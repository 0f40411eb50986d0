#include "world/dynamics/moving_object.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <cmath>
#include <cstdint>

namespace maille::deform {

MovingObject::MovingObject(const WorldObject& object, int dimension, bool with_mass) : has_mass(with_mass) {
  const Specimen& body = object.scene.specimen;
  const Grid& grid = body.grid;
  Eigen::Vector3d edge = Eigen::Vector3d::Zero();
  double volume = 1; // of a cell; for 1 m of thickness in two dimensions
  for (int a = 0; a < dimension; ++a) {
    edge[a] = grid.spacing()[a];
    volume *= edge[a];
  }
  const double of_cell = object.density * volume;
  const auto middle = [&](std::int64_t cell) {
    const Index3 at = grid.cell_at(cell);
    return Eigen::Vector3d((at[0] + 0.5) * edge[0], (at[1] + 0.5) * edge[1], (at[2] + 0.5) * edge[2]);
  };
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell)
    if (body.is_matter(cell)) {
      mass += of_cell;
      centre += of_cell * middle(cell);
    }
  centre /= mass;
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero(); // moments of the mass
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell)
    if (body.is_matter(cell)) {
      const Eigen::Vector3d x = middle(cell) - centre;
      second += of_cell * x * x.transpose();
      second.diagonal() += of_cell / 12 * edge.cwiseAbs2();
    }
  inertia = second.trace() * Eigen::Matrix3d::Identity() - second;
  for (int a = 0; a < dimension; ++a)
    velocity[a] = object.velocity[a];
}

double MovingObject::energy(const Pose& pose) const {
  return 0.5 * mass * velocity.squaredNorm() + 0.5 * spin.dot(inertia_in_world(pose) * spin);
}

Eigen::Vector3d Fall::velocity(const Eigen::Vector3d& before, double time) const {
  if (damping == 0)
    return before + time * gravity;
  const double left = std::exp(-damping * time);
  return left * before + (1 - left) / damping * gravity;
}

Eigen::Vector3d Fall::way(const Eigen::Vector3d& before, double time) const {
  if (damping == 0)
    return time * before + 0.5 * time * time * gravity;
  const double gone = -std::expm1(-damping * time) / damping;
  return gone * before + (time - gone) / damping * gravity;
}

Pose shifted_and_turned(const MovingObject& object, const Pose& pose, const Eigen::Vector3d& shift,
                        const Eigen::Vector3d& turn) {
  Pose moved = pose;
  if (const double angle = turn.norm(); angle > 0) {
    const Eigen::AngleAxisd by(angle, turn / angle);
    moved.rotation =
        Eigen::Quaterniond(by * Eigen::Quaterniond(pose.rotation)).normalized().toRotationMatrix();
    moved.position = object.place(pose) - moved.rotation * object.centre;
  }
  moved.position += shift;
  return moved;
}

void Fall::move(MovingObject& object, Pose& pose, double time) const {
  const Eigen::Vector3d shift = way(object.velocity, time);
  object.velocity = velocity(object.velocity, time);
  if (object.spin.isZero(0)) {
    pose.position += shift;
    return;
  }
  const Eigen::Vector3d momentum = object.inertia_in_world(pose) * object.spin;
  const double turning = damping == 0 ? time : -std::expm1(-damping * time) / damping;
  const Pose half = shifted_and_turned(object, pose, {0, 0, 0}, 0.5 * turning * object.spin);
  const Eigen::Vector3d spin = object.inertia_in_world(half).inverse() * momentum;
  pose = shifted_and_turned(object, pose, shift, turning * spin);
  object.spin = std::exp(-damping * time) * (object.inertia_in_world(pose).inverse() * momentum);
}

} // namespace maille::deform
