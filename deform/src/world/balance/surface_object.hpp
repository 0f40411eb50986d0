#pragma once
/// One object of a world whose objects meet with their surfaces: a skin, and what moves it.
///
/// SurfaceObject: the skin's nodes at rest and where they are, x = position + rotation (rest + displacement).
///   RigidPart    shift and turn as a whole. A spring or inertia draws it to its target.
///   SoftPart     displacements of a body's nodes in its frame: what handles and holds make of it without
///                contacts (`unloaded`), plus the response to the forces of contacts.
///
/// Both are moved by rounds (Balance), which ask each part for its response to forces and let it go a part of
/// the way there. A Vector6 is a shift and a turn, or a force and a moment.

#include "world/balance/soft_part.hpp"

#include <array>
#include <optional>

namespace maille::deform {

/// How an object moves as a whole, about its middle.
///
/// Free: a weak spring keeps it where a round begins (drag); at rest the forces balance without it. Led: a
/// spring draws it to its target. In time: inertia takes the spring's place.
class RigidPart {
public:
  void hold(bool moves, double stiffness) {
    moves_ = moves;
    stiffness_ = stiffness;
  }
  bool moves() const { return moves_; }
  void set_stiffness(double stiffness) { stiffness_ = stiffness; }
  /// @param inertia  mass and inertia over the square of a step, of shifts and then turns
  void set_inertia(const std::optional<Matrix6>& inertia) { inertia_ = inertia; }
  /// Neither a hand nor inertia says where it is to be.
  bool is_free() const { return moves_ && !target && !inertia_; }
  void place(const Eigen::Vector3d& middle, double radius) {
    middle_ = middle;
    radius_ = radius;
  }
  const Eigen::Vector3d& middle() const { return middle_; }
  double radius() const { return radius_; }
  /// Distance of a pose from the target [m]; 0 without one.
  double distance_to_target(const Pose& pose) const;

  /// @param sum_of_forces  sum of the sizes of its contacts' forces [N]
  /// @param drag  [N/m] for that sum
  void begin_round(double sum_of_forces, double drag) {
    sum_of_forces_ = sum_of_forces;
    drag_stiffness_ = std::max(stiffness_, drag);
  }
  /// @param drag  factor on the stiffness that holds a free object
  Matrix6 compliance(double drag) const;
  /// Shift and turn that the target asks for.
  Vector6 wanted(const Pose& pose) const;
  /// Shift, and turn times radius.
  Vector6 way_of(const Vector6& motion) const;
  /// True if a free object only drifts, steadily and under negligible force.
  bool only_drifts(const Vector6& motion, double drag, double step, bool has_gone);
  /// Product of the way of the last round with this one's.
  double onwards(const Vector6& motion);
  const Vector6& way() const { return way_; }
  void add_to_path(const Vector6& motion) { path_ += motion; }
  const Vector6& path() const { return path_; } ///< sum of all motions

  std::optional<Pose> target; ///< where a hand has it, or where it would fly to
private:
  bool moves_ = false;
  Eigen::Vector3d middle_ = Eigen::Vector3d::Zero(); ///< in the world [m]
  double radius_ = 0;                                ///< of the object about it [m]
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
  /// True if a direction of the world has a part along an axis of its frame.
  bool is_along(int axis, const Eigen::Vector3d& direction) const {
    return std::abs(pose.rotation.col(axis).dot(direction)) > 1e-12;
  }
  /// True if a node can never move along a direction of the world.
  bool is_held_along(std::int32_t node, const Eigen::Vector3d& direction) const;
  /// True if a node can never move.
  bool is_held(std::int32_t node) const {
    return kind == ObjectKind::fixed || (is_body() && !rigid.moves() && soft->is_held(node));
  }
  /// The node's number among the voxels of a rigid object, or in the grid of a body.
  std::int64_t voxel(std::int32_t node) const;
  /// True if a node of a rigid object is within a plane of its faces.
  bool is_flat(std::int32_t node) const { return !is_body() && is_flat_[node]; }
  /// Puts the skin where pose and displacement say.
  void place();
  /// The same for the nodes that rounds move.
  void place_watched();
  void turn_and_shift(const Vector6& motion);
  /// Largest distance that a response moves anything [m].
  double furthest(const Response& response) const;
  /// Corners of a cell of matter, counted in the order of the grid, where they are now.
  std::vector<Eigen::Vector3d> corners(std::int32_t cell);

  int dimension;
  ObjectKind kind;
  Skin skin;
  Pose pose;
  std::vector<Eigen::Vector3d> rest; ///< of the skin's nodes, in the object's frame [m]
  std::vector<Eigen::Vector3d> at;   ///< where they are, in the world [m]
  Eigen::AlignedBox3d box;           ///< about them
  std::optional<Eigen::Vector3d>
      centre; ///< of mass, in its frame, about which it turns where time passes [m]
  RigidPart rigid;
  std::optional<SoftPart> soft; ///< of deformable objects

private:
  void place(std::int32_t node);
  Eigen::Vector3d rest_of(const Index3& node) const;

  const Specimen* specimen_;
  const PosedLattice* lattice_ = nullptr; ///< of a body
  std::vector<std::int32_t> voxel_;       ///< of a rigid object, by the cell of matter
  std::vector<bool> is_flat_;             ///< by node
  std::vector<std::int64_t> matter_;      ///< cells of the grid, once they were asked for
  std::vector<std::int32_t> skin_node_;   ///< likewise, of a node of the grid; -1: none
};

} // namespace maille::deform
