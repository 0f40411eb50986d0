#pragma once
/// One object of a world with surface contact: its skin, and its degrees of freedom.
///
/// SurfaceObject: rest and present positions of the skin's nodes, x = position + rotation (rest +
/// displacement).
///   RigidPart    shift and rotation of the whole object. A spring or inertia pulls it to its target.
///   SoftPart     displacements of a body's nodes in its frame: the displacement without contacts, from
///                handles and holds (`unloaded`), plus the response to contact forces.
///
/// Rounds (Balance) evaluate the response of each part to forces, and move it by a part of that response. A
/// Vector6 is a shift and a rotation, or a force and a moment.

#include "world/balance/soft_part.hpp"

#include <array>
#include <optional>

namespace maille::deform {

/// Rigid motion of an object about its middle.
///
/// Free: a weak spring holds it at its pose at the start of a round (drag); at rest the forces balance
/// without the spring. Led: a spring pulls it to its target. With dynamics, inertia replaces the spring.
class RigidPart {
public:
  void hold(bool moves, double stiffness) {
    moves_ = moves;
    stiffness_ = stiffness;
  }
  bool moves() const { return moves_; }
  void set_stiffness(double stiffness) { stiffness_ = stiffness; }
  /// @param inertia  mass and inertia over the square of a time step; shifts, then rotations
  void set_inertia(const std::optional<Matrix6>& inertia) { inertia_ = inertia; }
  /// True if neither a drive nor inertia prescribes a target.
  bool is_free() const { return moves_ && !target && !inertia_; }
  void place(const Eigen::Vector3d& middle, double radius) {
    middle_ = middle;
    radius_ = radius;
  }
  const Eigen::Vector3d& middle() const { return middle_; }
  double radius() const { return radius_; }
  /// Distance of a pose from the target [m]; 0 without one.
  double distance_to_target(const Pose& pose) const;

  /// @param sum_of_forces  sum of the magnitudes of its contact forces [N]
  /// @param drag  stiffness for that sum [N/m]
  void begin_round(double sum_of_forces, double drag) {
    sum_of_forces_ = sum_of_forces;
    drag_stiffness_ = std::max(stiffness_, drag);
  }
  /// @param drag  factor on the stiffness that holds a free object
  Matrix6 compliance(double drag) const;
  /// Shift and rotation from a pose to the target.
  Vector6 wanted(const Pose& pose) const;
  /// Shift, and rotation times radius.
  Vector6 way_of(const Vector6& motion) const;
  /// True if a free object only drifts, steadily and under negligible force.
  bool only_drifts(const Vector6& motion, double drag, double step, bool has_gone);
  /// Dot product of the steps of the last round and this one; stores this one.
  double dot_with_last_step(const Vector6& motion);
  const Vector6& way() const { return way_; }
  void add_to_path(const Vector6& motion) { path_ += motion; }
  const Vector6& path() const { return path_; } ///< sum of all motions

  std::optional<Pose> target; ///< of a drive, or of free flight
private:
  bool moves_ = false;
  Eigen::Vector3d middle_ = Eigen::Vector3d::Zero(); ///< in the world [m]
  double radius_ = 0;                                ///< of the object about its middle [m]
  double stiffness_ = 0, drag_stiffness_ = 0;        ///< [N/m]
  double sum_of_forces_ = 0;
  std::optional<Matrix6> inertia_;
  Vector6 way_ = Vector6::Zero(), drift_ = Vector6::Zero(), path_ = Vector6::Zero();
};

/// Motion of one object under the forces of a round.
struct Response {
  Eigen::VectorXd displacement;                        ///< of SoftPart::moved()
  std::vector<std::pair<std::int64_t, double>> forces; ///< on components, sorted
  Vector6 motion = Vector6::Zero();                    ///< shift and turn
};

class SurfaceObject {
public:
  SurfaceObject(const WorldObjects& world, int object);

  bool is_body() const { return soft.has_value(); }
  /// True if a direction in the world has a component along an axis of the object's frame.
  bool is_along(int axis, const Eigen::Vector3d& direction) const {
    return std::abs(pose.rotation.col(axis).dot(direction)) > 1e-12;
  }
  /// True if a node can never move along a direction of the world.
  bool is_held_along(std::int32_t node, const Eigen::Vector3d& direction) const;
  /// True if a node can never move.
  bool is_held(std::int32_t node) const {
    return kind == ObjectKind::fixed || (is_body() && !rigid.moves() && soft->is_held(node));
  }
  /// Number of a node: the voxel of a rigid object, the grid node of a body.
  std::int64_t voxel(std::int32_t node) const;
  /// True if all faces at a node of a rigid object lie in one plane.
  bool is_flat(std::int32_t node) const { return !is_body() && is_flat_[node]; }
  /// Updates the positions of the skin from pose and displacement.
  void place();
  /// The same for the nodes that rounds move.
  void place_watched();
  void turn_and_shift(const Vector6& motion);
  /// Largest motion of any point in a response [m].
  double furthest(const Response& response) const;
  /// Present positions of the corners of a cell of matter; `cell` counts in the order of the grid.
  std::vector<Eigen::Vector3d> corners(std::int32_t cell);

  int dimension;
  ObjectKind kind;
  Skin skin;
  Pose pose;
  std::vector<Eigen::Vector3d> rest;     ///< of the skin's nodes, in the object's frame [m]
  std::vector<Eigen::Vector3d> at;       ///< present positions, in the world [m]
  Eigen::AlignedBox3d box;               ///< bounding box
  std::optional<Eigen::Vector3d> centre; ///< of mass, in its frame: centre of rotation with dynamics [m]
  RigidPart rigid;
  std::optional<SoftPart> soft; ///< of deformable objects

private:
  void place(std::int32_t node);
  Eigen::Vector3d rest_of(const Index3& node) const;

  const Specimen* specimen_;
  const PosedLattice* lattice_ = nullptr; ///< of a body
  std::vector<std::int32_t> voxel_;       ///< of a rigid object, by the cell of matter
  std::vector<bool> is_flat_;             ///< by node
  std::vector<std::int64_t> matter_;      ///< cells of the grid; filled on first use
  std::vector<std::int32_t> skin_node_;   ///< of a node of the grid; -1: none; filled on first use
};

} // namespace maille::deform
