#pragma once
/// Haptic collision detection: surfaces of bodies, surroundings of a tool, and the proxy of the tool.

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

/// Surface of a body: the outer faces of its cells, each as two triangles between its displaced corners, in
/// the world. The triangles form a closed surface: paths enter only through a triangle.
///
/// Immutable, so that any number of threads may use it.
///
/// Cost        construction 0.3 us a face; a path of a cell's length 0.2 us
/// Memory      120 bytes a face
/// Checked by  tests/deform/probe/proxy_test.cpp
class BodySurface {
public:
  /// @param scene three-dimensional @param displacement of its nodes, in its frame [m] @param pose of its
  ///        frame in the world
  /// @throws std::invalid_argument for a scene of another dimension, or a body that is not finite
  BodySurface(const Scene& scene, const Displacement& displacement, const Pose& pose);

  struct Face {
    std::int64_t cell;
    int axis; ///< of its normal at rest, in the body's frame
    bool upper;
    std::array<std::int32_t, 4> corners; ///< cyclic; outward normal by the right-hand rule
  };
  std::span<const Face> faces() const { return faces_; }
  /// Node of a corner in the scene's grid.
  std::int64_t node(std::int32_t corner) const { return nodes_[corner]; }
  /// Position of a corner, in the world [m].
  const Eigen::Vector3d& position(std::int32_t corner) const { return positions_[corner]; }
  const Pose& pose() const { return pose_; }

  struct Hit {
    double time; ///< 0 to 1 along the path
    std::int32_t face;
    Eigen::Vector3d normal; ///< of the triangle, outwards
    double distance,
        towards; ///< distance from its plane at the start, and approach to it along the whole path [m]
  };
  /// First entry of a straight path from outside; of simultaneous ones, the face with the smallest number.
  std::optional<Hit> first_hit(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;
  /// True if a point is in the body, by the parity of crossings of a straight ray. Rays near an edge are
  /// rejected; if four are rejected, every triangle is tested.
  /// Cost  1 us, increasing with the body's size along one axis
  bool is_inside(const Eigen::Vector3d& point) const;
  /// The same by the solid angle of the surface: reference for tests. Tests every triangle.
  bool is_inside_of_every_triangle(const Eigen::Vector3d& point) const;

  /// Distance at which a point stops before a triangle [m]: a millionth of the least spacing.
  double skin() const { return skin_; }
  std::int64_t bytes() const;

private:
  using Triangle = std::array<const Eigen::Vector3d*, 3>;

  void add_faces(const Scene& scene);
  void place_corners(const Scene& scene, const Displacement& displacement);
  void sort_into_boxes();
  Triangle triangle(std::int32_t face, int half) const;
  /// Updates `hit` if the path enters through the face earlier.
  void ask(std::int32_t face, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
           std::optional<Hit>& hit) const;
  /// Number of crossings of a ray with the surface; nothing if it is near an edge.
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
  // Faces sorted into the boxes of a grid that their bounding boxes intersect.
  Eigen::Vector3d low_ = Eigen::Vector3d::Zero(), high_ = Eigen::Vector3d::Zero();
  double edge_ = 1; ///< of a box [m]
  Index3 n_boxes_{1, 1, 1};
  std::vector<std::int64_t> begins_;
  std::vector<std::int32_t> sorted_;
};

/// Contact of a tool with an obstacle, and its blocked direction.
struct Obstacle {
  Eigen::Vector3d normal =
      Eigen::Vector3d::Zero(); ///< unit vector away from the matter; motion against it is blocked
  int body = -1;               ///< number of the surface; -1: a cell of the map, or its border
  std::int32_t face = -1;      ///< of the body's surface
  Eigen::Vector3d point = Eigen::Vector3d::Zero(); ///< of the tool in contact, in the world [m]
};

/// Obstacles: an occupancy map, whose occupied cells and border are rigid, and the surfaces of deformable
/// bodies.
///
/// A tool's voxels are points. Against the map they move as in RigidWorld, exact for every cell on the way,
/// including rotations. Against surfaces, voxels with an open side move along straight lines; rotations are
/// divided into pieces of at most a quarter of a cell, after each of which no voxel is in a body.
class Surroundings {
public:
  /// @param map null: no map and no border @param cell_size of the map [m]; without a map the unit of small
  ///        distances
  Surroundings(const OccupancyMap* map, const Vec3& cell_size,
               std::vector<std::shared_ptr<const BodySurface>> bodies = {});

  const OccupancyMap* map() const { return map_; }
  const Vec3& cell_size() const { return cell_size_; }
  int n_bodies() const { return static_cast<int>(bodies_.size()); }
  const BodySurface& body(int number) const { return *bodies_[number]; }

  /// Moves a tool as far as possible, to just before its first contact.
  /// @param[in,out] pose start, then end, both outside of matter @param[out] done part of the motion, 0 to 1
  std::optional<Obstacle> move(const RigidShape& tool, const RigidMotion& motion, Pose& pose,
                               double& done) const;

  /// Number of voxels of a tool that are in blocked cells or in bodies.
  std::int64_t n_inside(const RigidShape& tool, const Pose& pose) const;

private:
  std::optional<Obstacle> move_before_bodies(const RigidShape& tool, const RigidMotion& motion,
                                             const Pose& from, double& done) const;
  std::optional<Obstacle> go_straight(const RigidShape& tool, const Pose& from, const Pose& end,
                                      double& done) const;
  Obstacle met(const Contact& contact, const RigidShape& tool, const Pose& pose) const;
  Obstacle turned_into(const RigidShape& tool, const RigidMotion& motion, const Pose& pose) const;
  /// True if any voxel with an open side is in a body.
  bool is_in_a_body(const RigidShape& tool, const Pose& pose) const;

  const OccupancyMap* map_;
  Vec3 cell_size_;
  std::vector<std::shared_ptr<const BodySurface>> bodies_;
};

/// An obstacle between the proxy and its goal, with the depth of the goal behind it.
struct Constraint {
  Obstacle obstacle;
  double depth = 0; ///< >= 0: goal = proxy - sum over constraints of depth * normal [m]
};

/// The step nearest to a requested one that does not violate any of the normals, with their multipliers: step
/// = requested + sum of depths * normals. Every subset of at most three normals is tried: exact, also for
/// oblique or coplanar normals.
struct AllowedStep {
  Eigen::Vector3d step = Eigen::Vector3d::Zero();
  std::array<double, 6> depth{};
};
/// @param wanted requested step @param constraints at most six
AllowedStep allowed_step(const Eigen::Vector3d& wanted, std::span<const Constraint> constraints);

/// The god-object: a reachable place of the tool outside of matter that is locally nearest to the goal.
///
/// It moves straight to the first obstacle, then to the nearest place that the obstacles so far allow, and so
/// on: a local minimum of the distance, along faces, into edges and corners and out of them. Before that a
/// tool of several voxels rotates as far as possible, by at most a few cells: about its middle, and if that
/// is blocked, with the shift and tilt that its contact surfaces require, smoothed over five cells. Faces are
/// those of cells of the map, perpendicular to its axes, and triangles of bodies: an oblique plane of cells
/// is a staircase.
///
/// Source      Zilles and Salisbury 1995 (IROS), with the inequalities of the Lagrange multipliers,
///             so that no list of active planes is needed. Departure: every contact is the first on the
///             whole way. Rotations: Ortega, Redon and Coquillart 2007
/// Cost        one voxel: 0.5 to 2 us a call
/// Repeatable  same bits on any machine
/// Checked by  tests/deform/probe/proxy_test.cpp
class Proxy {
public:
  /// @param tool voxels; a single one is a point @param middle initial pose of the middle of its lattice,
  ///        outside of matter [m]
  Proxy(RigidShape tool, const Pose& middle);

  /// Moves as near to a pose of the middle as possible.
  void follow(const Surroundings& surroundings, const Pose& goal);

  const RigidShape& tool() const { return tool_; }
  /// Pose of the tool's lattice, in RigidWorld's convention.
  const Pose& pose() const { return pose_; }
  Eigen::Vector3d middle() const { return pose_.position + pose_.rotation * middle_; }
  /// Constraints that block the last goal; empty if it was reached.
  std::span<const Constraint> constraints() const { return std::span(constraints_).first(n_constraints_); }
  bool is_turn_blocked() const { return is_turn_blocked_; }

private:
  /// Rotates as far as possible, with the shifts that this requires.
  void turn(const Surroundings& surroundings, const Pose& goal);
  double slide_and_turn(const Surroundings& surroundings, const Pose& goal, double length);
  bool free_itself(const Surroundings& surroundings, const Pose& goal);
  double distance(const Pose& goal) const;
  /// @return the part of the motion that was done
  double move_by(const Surroundings& surroundings, const Eigen::Vector3d& shift, const Eigen::Vector3d& turn,
                 std::optional<Obstacle>& obstacle);
  /// Slides along up to three walls and their intersections. @return distance moved [m]
  double go(const Surroundings& surroundings, const Eigen::Vector3d& goal, double least_step);

  RigidShape tool_;
  Eigen::Vector3d middle_; ///< of the lattice, in its frame [m]
  double arm_ = 0;         ///< root mean square distance of its voxels from the middle [m]
  Pose pose_;
  std::array<Constraint, 6> constraints_;
  std::size_t n_constraints_ = 0;
  bool is_turn_blocked_ = false;
};

/// A tool of one voxel: a point.
RigidShape point_tool(const Vec3& cell_size);

} // namespace maille::deform
