#pragma once
/// Rigid objects that share a world and cannot enter one another.

#include "maille/deform/world/occupancy_map.hpp"
#include "maille/deform/world/rigid_shape.hpp"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace maille::deform {

/// Where a voxel met something that it cannot enter.
struct Contact {
  double time = 0;          ///< of the motion, 0 to 1
  std::int32_t voxel = 0;   ///< of the moving object
  Index3 cell{};            ///< that it would have entered, perhaps outside the world
  int axis = 0;             ///< of the face that it would have passed through
  int direction = 1;        ///< in which, along that axis: -1 or 1
  VoxelId other = no_voxel; ///< voxel in the way; the empty id: the border of the world
};

struct MoveResult {
  double fraction = 0;           ///< of the motion that was done
  std::vector<Contact> contacts; ///< in the order met; empty: the whole motion was free
};

/// Fixed and rigid objects in one occupancy map.
///
/// Lengths in metres; the world's corner is the origin, cell i covers [i, i + 1) cell sizes along each axis.
/// Outside is a wall. A cell is of one object at most: of the one that has a voxel's middle in it (of several
/// voxels the one with the smallest number stands for all), or whose matter holds the cell's own middle, at
/// any turn and spacing. Objects never overlap: adding is refused, moving stops short. Matter thinner than a
/// cell also takes the free cells that seal it (see world/occupancy/posed_matter.hpp in the sources).
///
/// Source      Gibson, Beyond volume rendering (1995), figures 1 and 3. Departures: the exact first contact
///             instead of halved steps, so that no wall is passed through at any speed.
/// Repeatable  same bits on any machine
/// Checked by  tests/deform/world/rigid_world_test.cpp
class RigidWorld {
public:
  /// @param cells per axis; 1 along z for two dimensions, where motions must stay in the plane
  ///        @param cell_size > 0 [m]
  RigidWorld(const Index3& cells, const Vec3& cell_size);

  const OccupancyMap& map() const { return map_; }
  /// For voxels of others, which the objects of this world then cannot enter: numbered from n_voxels() on,
  /// never in cells of its objects.
  OccupancyMap& map_of_all() { return map_; }
  /// Voxels of all its objects: their numbers are below this.
  VoxelId n_voxels() const { return n_voxels_; }
  const Vec3& cell_size() const { return cell_size_; }

  struct Added {
    std::optional<int> object;         ///< its number
    std::optional<Contact> refused_at; ///< the first voxel whose cell is blocked
  };
  /// Adds an object that can be moved, or one that is only in the way. @param may_meet others in a cell
  Added add(RigidShape shape, const Pose& pose, bool may_meet = false);
  int n_objects() const { return static_cast<int>(objects_.size()); }
  const RigidShape& shape(int object) const { return at(object).shape; }
  const Pose& pose(int object) const { return at(object).pose; }
  /// Object with that voxel; -1 for voxels of no object of this world.
  int object_of(VoxelId id) const;

  /// How many voxels of a shape that is not an object of this world would have their middles in blocked cells
  /// there.
  std::int32_t n_blocked(const RigidShape& shape, const Pose& pose) const;

  /// How many voxels of an object would have their middles, there, in cells of others or outside.
  std::int32_t n_blocked(int object, const Pose& pose) const;

  /// What an object touches with its voxels' boxes: cells of others whose middles are at most `reach` [cells]
  /// outside them. What it touches with voxels' middles is not among it. Time is 0.
  std::vector<Contact> touched(int object, double reach) const;

  /// Moves an object as far as it can go: up to a billionth of a cell before the first contact, which is
  /// found exactly.
  MoveResult move(int object, const RigidMotion& motion);
  /// Takes an object out of the map, for a caller that moves it by a rule of its own and puts it back.
  void take_out(int object) { take(at(object)); }
  void put_back(int object, const Pose& pose);

  /// Puts all objects where they are said to be, into an empty map; who comes first has a cell that two would
  /// take. For worlds whose objects are kept apart by their surfaces. @param poses one an object
  void place(std::span<const Pose> poses);

  std::int64_t bytes() const;

private:
  struct Object {
    RigidShape shape;
    Pose pose;
    VoxelId first;
    std::vector<Index3> between; ///< cells that are its own though no voxel's middle lies in them
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
