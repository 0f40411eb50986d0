#pragma once
/// A tool that follows a device's and never enters matter.

#include "maille/deform/probe/surroundings.hpp"

#include <array>
#include <span>

namespace maille::deform {

/// An obstacle that keeps the proxy from its goal, and how far.
struct Constraint {
  Obstacle obstacle;
  double depth = 0; ///< >= 0: goal = proxy - sum over constraints of depth * normal [m]
};

/// The step nearest to a wanted one that goes against none of the normals, and what each normal adds to the wanted one for that:
/// step = wanted + sum of depths * normals. Every choice of at most three normals is tried: exact, and right where they do not stand at right
/// angles or lie in one plane.
struct AllowedStep {
  Eigen::Vector3d step = Eigen::Vector3d::Zero();
  std::array<double, 6> depth{};
};
/// @param constraints at most six
AllowedStep allowed_step(const Eigen::Vector3d& wanted, std::span<const Constraint> constraints);

/// The god-object: of all places that the tool can come to without entering matter, one that is nearest to
/// the goal.
///
/// It goes straight to the first obstacle, then to the nearest place that the obstacles met allow, and so on:
/// a local least distance, along faces, into edges and corners and out again. Before that the tool turns as
/// far as it can about its middle. Faces are those of cells of the map, at right angles to its axes, and
/// triangles of bodies: an oblique plane of the map is a staircase.
///
/// Source      Zilles and Salisbury 1995 (IROS); of its Lagrange multipliers the inequalities are kept, so
///             that no list of active planes is needed. Departure: every contact is found as the first on the
///             whole way
/// Cost        one voxel: 0.5 to 2 us a call
/// Repeatable  same bits on any machine
/// Checked by  tests/deform/probe/proxy_test.cpp
class Proxy {
public:
  /// @param tool voxels; one alone is a point @param middle where the middle of its lattice is [m] and how it is turned, in no matter
  Proxy(RigidShape tool, const Pose& middle);

  /// Goes as near to a pose of the middle as it can.
  void follow(const Surroundings& surroundings, const Pose& goal);

  const RigidShape& tool() const { return tool_; }
  /// Of the tool's lattice, as RigidWorld has it.
  const Pose& pose() const { return pose_; }
  Eigen::Vector3d middle() const { return pose_.position + pose_.rotation * middle_; }
  /// What keeps it from the last goal; none: it is there.
  std::span<const Constraint> constraints() const { return std::span(constraints_).first(n_constraints_); }
  bool is_turn_blocked() const { return is_turn_blocked_; }

private:
  void turn(const Surroundings& surroundings, const Eigen::Matrix3d& rotation);
  /// Up to three walls and what is between them. @return how far it came [m]
  double go(const Surroundings& surroundings, const Eigen::Vector3d& goal, double least_step);

  RigidShape tool_;
  Eigen::Vector3d middle_; ///< of the lattice, in its frame [m]
  Pose pose_;
  std::array<Constraint, 6> constraints_;
  std::size_t n_constraints_ = 0;
  bool is_turn_blocked_ = false;
};

/// A tool of one voxel: a point.
RigidShape point_tool(const Vec3& cell_size);

} // namespace maille::deform
