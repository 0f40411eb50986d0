#pragma once
/// All that a tool may meet.

#include "maille/deform/probe/body_surface.hpp"
#include "maille/deform/world/occupancy_map.hpp"
#include "maille/deform/world/rigid_world.hpp"

#include <memory>
#include <optional>
#include <vector>

namespace maille::deform {

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
/// A tool's voxels are points: against the map as in RigidWorld, to the last cell passed through, turns included; against surfaces those that
/// are open to a side, along straight lines; turns in pieces of at most a quarter of a cell, behind each of which no voxel is in a body.
class Surroundings {
public:
  /// @param map null: none, and no border @param cell_size of the map [m]; without a map what small distances are measured by
  Surroundings(const OccupancyMap* map, const Vec3& cell_size,
               std::vector<std::shared_ptr<const BodySurface>> bodies = {});

  const OccupancyMap* map() const { return map_; }
  const Vec3& cell_size() const { return cell_size_; }
  int n_bodies() const { return static_cast<int>(bodies_.size()); }
  const BodySurface& body(int number) const { return *bodies_[static_cast<std::size_t>(number)]; }

  /// Moves a tool as far as it can go: up to just before what it first meets.
  /// @param pose where it is, in no matter; then where it has come to, in no matter either @param done of the motion, 0 to 1
  std::optional<Obstacle> move(const RigidShape& tool, const RigidMotion& motion, Pose& pose,
                               double& done) const;

  /// Voxels of a tool that are in matter: in blocked cells, and in bodies.
  std::int64_t n_inside(const RigidShape& tool, const Pose& pose) const;

private:
  std::optional<Obstacle> move_before_bodies(const RigidShape& tool, const RigidMotion& motion,
                                             const Pose& from, double& done) const;
  std::optional<Obstacle> go_straight(const RigidShape& tool, const Pose& from, const Pose& end,
                                      double& done) const;
  Obstacle turned_into(const RigidShape& tool, const RigidMotion& motion, const Pose& pose) const;
  /// Whether any voxel that is open to a side is in a body.
  bool is_in_a_body(const RigidShape& tool, const Pose& pose) const;

  const OccupancyMap* map_;
  Vec3 cell_size_;
  std::vector<std::shared_ptr<const BodySurface>> bodies_;
};

} // namespace maille::deform
