#include "maille/deform/probe/touch.hpp"

#include "world/touch/allowed_twist.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace maille::deform {

namespace {

/// Projection of the requested step on the orthogonal complement of selected normals.
Eigen::Vector3d left_over(const Eigen::Vector3d& wanted, const std::array<Eigen::Vector3d, 3>& normals,
                          int n) {
  if (n == 0)
    return wanted;
  if (n == 1)
    return wanted - normals[0].dot(wanted) * normals[0];
  if (n == 3)
    return Eigen::Vector3d::Zero();
  const Eigen::Vector3d edge = normals[0].cross(normals[1]);
  return edge.dot(wanted) / edge.squaredNorm() * edge;
}

/// Multipliers of selected normals as equality constraints; nothing if the normals are linearly dependent.
std::optional<Eigen::Vector3d> multipliers(const Eigen::Vector3d& wanted,
                                           const std::array<Eigen::Vector3d, 3>& normals, int n) {
  Eigen::Matrix3d gram = Eigen::Matrix3d::Identity();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (int i = 0; i < n; ++i) {
    const auto& normal = normals[i];
    right[i] = -normal.dot(wanted);
    for (int j = 0; j < n; ++j)
      gram(i, j) = normal.dot(normals[j]);
  }
  if (!(gram.determinant() > 1e-10))
    return std::nullopt;
  return Eigen::Vector3d(gram.inverse() * right);
}

} // namespace

AllowedStep allowed_step(const Eigen::Vector3d& wanted, std::span<const Constraint> constraints) {
  const auto n = static_cast<unsigned>(constraints.size());
  const double rounding = 1e-12 * wanted.norm();
  AllowedStep best; // no step if no set of three is feasible
  double nearest = wanted.squaredNorm();
  bool is_found = false;
  for (unsigned chosen = 0; chosen < 1u << n; ++chosen) {
    std::array<Eigen::Vector3d, 3> normals;
    std::array<std::size_t, 3> numbers{};
    int n_chosen = 0;
    for (std::size_t i = 0; i < n && n_chosen <= 3; ++i)
      if ((chosen >> i & 1) != 0 && n_chosen++ < 3) {
        normals[n_chosen - 1] = constraints[i].obstacle.normal;
        numbers[n_chosen - 1] = i;
      }
    if (n_chosen > 3)
      continue;
    const auto added = multipliers(wanted, normals, n_chosen);
    if (!added)
      continue;
    AllowedStep trial;
    trial.step = left_over(wanted, normals, n_chosen);
    bool is_allowed = true;
    for (int i = 0; i < n_chosen; ++i) {
      is_allowed = is_allowed && (*added)[i] >= 0;
      trial.depth[numbers[i]] = (*added)[i];
    }
    for (const Constraint& constraint : constraints)
      is_allowed = is_allowed && constraint.obstacle.normal.dot(trial.step) >= -rounding;
    const double distance = (trial.step - wanted).squaredNorm();
    if (is_allowed && (!is_found || distance < nearest)) {
      is_found = true;
      nearest = distance;
      best = trial;
    }
  }
  return best;
}

Proxy::Proxy(RigidShape tool, const Pose& middle) : tool_(std::move(tool)), pose_(middle) {
  middle_ = tool_.middle();
  if (tool_.n_voxels() == 1) // a point has no rotation
    pose_.rotation.setIdentity();
  pose_.position -= pose_.rotation * middle_;
  double squares = 0;
  for (std::int32_t voxel = 0; voxel < tool_.n_voxels(); ++voxel)
    squares += (tool_.centre_of(voxel) - middle_).squaredNorm();
  arm_ = std::sqrt(squares / tool_.n_voxels());
}

void Proxy::follow(const Surroundings& surroundings, const Pose& goal) {
  is_turn_blocked_ = false;
  if (tool_.n_voxels() > 1)
    turn(surroundings, goal);
  const Vec3& cell = surroundings.cell_size();
  const double least_step = least_step_over_cell * *std::ranges::min_element(cell);
  for (int pass = 0; pass < most_obstacles; ++pass)
    if (go(surroundings, goal.position, least_step) <= least_step)
      break;
}

double Proxy::go(const Surroundings& surroundings, const Eigen::Vector3d& goal, double least_step) {
  const Eigen::Vector3d from = middle();
  n_constraints_ = 0;
  while (n_constraints_ < constraints_.size()) {
    const AllowedStep allowed = allowed_step(goal - middle(), std::span(constraints_).first(n_constraints_));
    for (std::size_t i = 0; i < n_constraints_; ++i)
      constraints_[i].depth = allowed.depth[i];
    if (allowed.step.norm() <= least_step)
      break;
    RigidMotion motion;
    motion.by = allowed.step;
    double done = 0;
    const auto obstacle = surroundings.move(tool_, motion, pose_, done);
    if (!obstacle)
      break;
    constraints_[n_constraints_++] = Constraint{*obstacle, 0};
  }
  return (middle() - from).norm();
}

RigidShape point_tool(const Vec3& cell_size) {
  return {{1, 1, 1}, cell_size, std::vector<std::uint8_t>{1}};
}

} // namespace maille::deform
