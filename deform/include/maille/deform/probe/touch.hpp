#pragma once
/// What a probe touches: surfaces of bodies, what surrounds a tool, and the tool's place outside of it.

#include "maille/deform/world/occupancy_map.hpp"
#include "maille/deform/world/rigid_shape.hpp"
#include "maille/deform/world/rigid_world.hpp"
#include "maille/scene/answer.hpp"

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace maille::deform {

/// Every face of a cell of matter with no matter behind it, as two triangles between its four displaced
/// corners, in the world. The triangles of a body close it: what is outside comes in through a triangle only.
///
/// Never changes once it is made, so that any number of threads may ask it.
///
/// Cost        making 0.3 us a face; a path of a cell's length 0.2 us
/// Memory      120 bytes a face
/// Checked by  tests/deform/probe/proxy_test.cpp
class BodySurface {
public:
  /// @param scene of three dimensions @param displacement of its nodes, in its frame [m] @param pose of its
  ///        frame in the world
  /// @throws std::invalid_argument for a scene of another dimension, or a body that is not finite
  BodySurface(const Scene& scene, const Displacement& displacement, const Pose& pose);

  struct Face {
    std::int64_t cell;
    int axis; ///< of its normal at rest, in the body's frame
    bool upper;
    std::array<std::int32_t, 4> corners; ///< round about, the normal by the right-hand rule outwards
  };
  std::span<const Face> faces() const { return faces_; }
  /// A corner's node, a number of the scene's grid.
  std::int64_t node(std::int32_t corner) const { return nodes_[corner]; }
  /// Where a corner is, in the world [m].
  const Eigen::Vector3d& position(std::int32_t corner) const { return positions_[corner]; }
  const Pose& pose() const { return pose_; }

  struct Hit {
    double time; ///< 0 to 1 along the path
    std::int32_t face;
    Eigen::Vector3d normal; ///< of the triangle, outwards
    double distance,
        towards; ///< from its plane at the path's begin, and gone towards it along the whole path [m]
  };
  /// Where a straight path first comes in from outside; of places at the same time, the face of the smallest
  /// number.
  std::optional<Hit> first_hit(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;
  /// Whether a point is in the body: by how often a straight way out crosses the skin. Ways that come near an
  /// edge are not believed; where four of them do, every triangle is asked.
  /// Cost  1 us, and with the body's size along one axis
  bool is_inside(const Eigen::Vector3d& point) const;
  /// The same by the solid angle that the skin fills: the oracle. Asks every triangle.
  bool is_inside_of_every_triangle(const Eigen::Vector3d& point) const;

  /// How far before a triangle a point stops [m]: a millionth of the least spacing.
  double skin() const { return skin_; }
  std::int64_t bytes() const;

private:
  using Triangle = std::array<const Eigen::Vector3d*, 3>;

  void add_faces(const Scene& scene);
  void place_corners(const Scene& scene, const Displacement& displacement);
  void sort_into_boxes();
  Triangle triangle(std::int32_t face, int half) const;
  /// Takes the earlier of `hit` and where the path comes through the face.
  void ask(std::int32_t face, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
           std::optional<Hit>& hit) const;
  /// How often a way crosses the skin; nothing where it comes near an edge.
  std::optional<int> n_crossings(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;
  Index3 box_of(const Eigen::Vector3d& point) const;
  std::size_t number_of(const Index3& box) const {
    return static_cast<std::size_t>(box[0] + n_boxes_[0] * (box[1] + std::int64_t{1} * n_boxes_[1] * box[2]));
  }
  std::span<const std::int32_t> faces_in(const Index3& box) const;

  Pose pose_;
  std::vector<Face> faces_;
  std::vector<std::int64_t> nodes_;
  std::vector<Eigen::Vector3d> positions_;
  double skin_ = 0;
  // Faces by the boxes of a grid that their own boxes touch.
  Eigen::Vector3d low_ = Eigen::Vector3d::Zero(), high_ = Eigen::Vector3d::Zero();
  double edge_ = 1; ///< of a box [m]
  Index3 n_boxes_{1, 1, 1};
  std::vector<std::int64_t> begins_;
  std::vector<std::int32_t> sorted_;
};

/// Where a tool met something, and which way it cannot go on.
struct Obstacle {
  Eigen::Vector3d normal =
      Eigen::Vector3d::Zero(); ///< of length 1, away from the matter: no way leads against it
  int body = -1;               ///< number of the surface; -1: a cell of the map, or its border
  std::int32_t face = -1;      ///< of the body's surface
  Eigen::Vector3d point = Eigen::Vector3d::Zero(); ///< of the tool that met it, in the world [m]
};

/// An occupancy map, whose taken cells and border are rigid, and the surfaces of deformable bodies.
///
/// A tool's voxels are points: against the map as in RigidWorld, to the last cell passed through, turns
/// included; against surfaces those that are open to a side, along straight lines; turns in pieces of at most
/// a quarter of a cell, behind each of which no voxel is in a body.
class Surroundings {
public:
  /// @param map null: none, and no border @param cell_size of the map [m]; without a map what small distances
  ///        are measured by
  Surroundings(const OccupancyMap* map, const Vec3& cell_size,
               std::vector<std::shared_ptr<const BodySurface>> bodies = {});

  const OccupancyMap* map() const { return map_; }
  const Vec3& cell_size() const { return cell_size_; }
  int n_bodies() const { return static_cast<int>(bodies_.size()); }
  const BodySurface& body(int number) const { return *bodies_[number]; }

  /// Moves a tool as far as it can go: up to just before what it first meets.
  /// @param pose where it is, in no matter; then where it has come to, in no matter either @param done of the
  ///        motion, 0 to 1
  std::optional<Obstacle> move(const RigidShape& tool, const RigidMotion& motion, Pose& pose,
                               double& done) const;

  /// Voxels of a tool that are in matter: in blocked cells, and in bodies.
  std::int64_t n_inside(const RigidShape& tool, const Pose& pose) const;

private:
  std::optional<Obstacle> move_before_bodies(const RigidShape& tool, const RigidMotion& motion,
                                             const Pose& from, double& done) const;
  std::optional<Obstacle> go_straight(const RigidShape& tool, const Pose& from, const Pose& end,
                                      double& done) const;
  Obstacle met(const Contact& contact, const RigidShape& tool, const Pose& pose) const;
  Obstacle turned_into(const RigidShape& tool, const RigidMotion& motion, const Pose& pose) const;
  /// Whether any voxel that is open to a side is in a body.
  bool is_in_a_body(const RigidShape& tool, const Pose& pose) const;

  const OccupancyMap* map_;
  Vec3 cell_size_;
  std::vector<std::shared_ptr<const BodySurface>> bodies_;
};

/// An obstacle that keeps the proxy from its goal, and how far.
struct Constraint {
  Obstacle obstacle;
  double depth = 0; ///< >= 0: goal = proxy - sum over constraints of depth * normal [m]
};

/// The step nearest to a wanted one that goes against none of the normals, and what each normal adds to the
/// wanted one for that: step = wanted + sum of depths * normals. Every choice of at most three normals is
/// tried: exact, and right where they do not stand at right angles or lie in one plane.
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
/// a local least distance, along faces, into edges and corners and out again. Before that a tool of several
/// voxels turns as far as it can, by a few cells at most: about its middle, and where that is stopped with
/// the shift and the tilt that the surfaces it touches ask for, smoothed over five cells. Faces are those of
/// cells of the map, at right angles to its axes, and triangles of bodies: an oblique plane is a staircase.
///
/// Source      Zilles and Salisbury 1995 (IROS); of its Lagrange multipliers the inequalities are kept, so
///             that no list of active planes is needed. Departure: every contact is found as the first on the
///             whole way. Turns: Ortega, Redon and Coquillart 2007
/// Cost        one voxel: 0.5 to 2 us a call
/// Repeatable  same bits on any machine
/// Checked by  tests/deform/probe/proxy_test.cpp
class Proxy {
public:
  /// @param tool voxels; one alone is a point @param middle where the middle of its lattice is [m] and how it
  ///        is turned, in no matter
  Proxy(RigidShape tool, const Pose& middle);

  /// Goes as near to a pose of the middle as it can.
  void follow(const Surroundings& surroundings, const Pose& goal);

  const RigidShape& tool() const { return tool_; }
  /// Pose of the tool's lattice, in RigidWorld's convention.
  const Pose& pose() const { return pose_; }
  Eigen::Vector3d middle() const { return pose_.position + pose_.rotation * middle_; }
  /// What keeps it from the last goal; none: it is there.
  std::span<const Constraint> constraints() const { return std::span(constraints_).first(n_constraints_); }
  bool is_turn_blocked() const { return is_turn_blocked_; }

private:
  /// Turns as far as it can, with the shifts that this asks for.
  void turn(const Surroundings& surroundings, const Pose& goal);
  double give_way(const Surroundings& surroundings, const Pose& goal, double length);
  bool free_itself(const Surroundings& surroundings, const Pose& goal);
  double distance(const Pose& goal) const;
  /// @return the part of the motion that was done
  double move_by(const Surroundings& surroundings, const Eigen::Vector3d& shift, const Eigen::Vector3d& turn,
                 std::optional<Obstacle>& obstacle);
  /// Up to three walls and what is between them. @return how far it came [m]
  double go(const Surroundings& surroundings, const Eigen::Vector3d& goal, double least_step);

  RigidShape tool_;
  Eigen::Vector3d middle_; ///< of the lattice, in its frame [m]
  double arm_ = 0;         ///< of its voxels about the middle, in the root mean square [m]
  Pose pose_;
  std::array<Constraint, 6> constraints_;
  std::size_t n_constraints_ = 0;
  bool is_turn_blocked_ = false;
};

/// A tool of one voxel: a point.
RigidShape point_tool(const Vec3& cell_size);

} // namespace maille::deform
