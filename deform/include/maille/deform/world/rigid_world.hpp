#pragma once
/// Rigid objects in one world, without overlaps.

#include "maille/deform/world/occupancy_map.hpp"
#include "maille/deform/world/rigid_shape.hpp"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace maille::deform {

/// First contact of a voxel with an obstacle.
struct Contact {
  double time = 0;          ///< of the motion, 0 to 1
  std::int32_t voxel = 0;   ///< of the moving object
  Index3 cell{};            ///< blocked cell, possibly outside the world
  int axis = 0;             ///< of the face of entry
  int direction = 1;        ///< along that axis: -1 or 1
  VoxelId other = no_voxel; ///< voxel in the way; no_voxel: the border of the world
};

struct MoveResult {
  double fraction = 0;           ///< of the motion that was done
  std::vector<Contact> contacts; ///< in the order met; empty: the whole motion was free
};

/// Fixed and rigid objects in one occupancy map.
///
/// Lengths in metres; the world's corner is the origin, cell i covers [i, i + 1) cell sizes along each axis.
/// Outside is a wall. A cell belongs to at most one object: the one with a voxel's middle in it (represented
/// by the smallest number of its voxels there), or whose matter contains the cell's middle, at any rotation
/// and spacing. Objects never overlap: overlapping additions are refused, and motions stop before a contact.
/// Matter thinner than a cell also occupies the free cells that seal it (see world/occupancy/posed_matter.hpp
/// in the sources).
///
/// Source      Gibson, Beyond volume rendering (1995), figures 1 and 3. Departures: the exact first contact
///             instead of halved steps, so that no motion passes through a wall at any speed.
/// Repeatable  same bits on any machine
/// Checked by  tests/deform/world/rigid_world_test.cpp
class RigidWorld {
public:
  /// @param cells per axis; 1 along z for two dimensions, where motions must stay in the plane
  ///        @param cell_size > 0 [m]
  RigidWorld(const Index3& cells, const Vec3& cell_size);

  const OccupancyMap& map() const { return map_; }
  /// The map, for voxels of other objects as obstacles: numbered from n_voxels() on, never in cells of
  /// objects of this world.
  OccupancyMap& map_of_all() { return map_; }
  /// Number of voxels of all objects: an upper bound of their numbers.
  VoxelId n_voxels() const { return n_voxels_; }
  const Vec3& cell_size() const { return cell_size_; }

  struct Added {
    std::optional<int> object;         ///< its number
    std::optional<Contact> refused_at; ///< the first voxel whose cell is blocked
  };
  /// Adds a movable or fixed object. @param may_meet true: it may share cells with others
  Added add(RigidShape shape, const Pose& pose, bool may_meet = false);
  int n_objects() const { return static_cast<int>(objects_.size()); }
  const RigidShape& shape(int object) const { return at(object).shape; }
  const Pose& pose(int object) const { return at(object).pose; }
  /// Object of a voxel; -1: none of this world.
  int object_of(VoxelId id) const;

  /// Number of voxels of a shape, not an object of this world, whose middles would be in blocked cells at a
  /// pose.
  std::int32_t n_blocked(const RigidShape& shape, const Pose& pose) const;

  /// Number of voxels of an object whose middles, at a pose, would be in cells of others or outside.
  std::int32_t n_blocked(int object, const Pose& pose) const;

  /// Contacts of the voxels' boxes of an object: cells of others whose middles are at most `reach` [cells]
  /// outside of them, except contacts of the voxels' middles. Time is 0.
  std::vector<Contact> touched(int object, double reach) const;

  /// Moves an object as far as possible: to a billionth of a cell before the first contact, which is exact.
  MoveResult move(int object, const RigidMotion& motion);
  /// Removes an object from the map, for callers that move it by their own rules and put it back.
  void take_out(int object) { take(at(object)); }
  void put_back(int object, const Pose& pose);

  /// Puts all objects at given poses into an empty map; the first object keeps a cell that two would occupy.
  /// For worlds with surface contact. @param poses by object
  void place(std::span<const Pose> poses);

  std::int64_t bytes() const;

private:
  struct Object {
    RigidShape shape;
    Pose pose;
    VoxelId first;
    std::vector<Index3> between; ///< its cells without a voxel's middle in them
  };

  const Object& at(int object) const { return objects_[object]; }
  Object& at(int object) { return objects_[object]; }
  void put(Object& object);
  void take(Object& object);
  std::optional<Contact> find_refusal(const RigidShape& shape, const Pose& pose, bool may_meet) const;

  OccupancyMap map_;
  Vec3 cell_size_;
  std::vector<Object> objects_;
  VoxelId n_voxels_ = 0;
};

} // namespace maille::deform
