#pragma once
/// The objects of a world: rigid and fixed ones in the occupancy map, bodies with their displacements.
///
/// A voxel's number in the map identifies its object: rigid and fixed objects come first, then bodies, each
/// with consecutive numbers. Engines with contact by cells keep the map up to date; engines with surface
/// contact only mark it as outdated, and map() updates it for the next reader.

#include "maille/deform/world/world.hpp"
#include "world/deformable_object.hpp"

#include <optional>
#include <vector>

namespace maille::deform {

/// Largest allowed initial overlap; positions with three digits cause less [cells].
inline constexpr double overlap_over_cell = 1e-3;

struct WorldObjects {
  /// @throws std::invalid_argument as World::World
  explicit WorldObjects(WorldScene scene);

  struct Member {
    ObjectKind kind;
    int index;                 ///< among rigid and fixed objects, or among bodies
    VoxelId first;             ///< of its voxels in the map
    bool is_driven = false;    ///< by a drive
    bool is_unsettled = false; ///< the last frame ended before it was at rest
  };

  /// The map, updated with all bodies.
  OccupancyMap& map() {
    if (is_map_outdated) {
      is_map_outdated = false;
      for (DeformableObject& body : bodies)
        body.put_into(rigid.map_of_all());
    }
    return rigid.map_of_all();
  }
  const Member& member(int object) const { return members[object]; }
  Member& member(int object) { return members[object]; }
  const WorldObject& object(int number) const { return scene.objects[number]; }
  /// Name for messages; -1: the border.
  std::string name(int object) const;
  DeformableObject& body(int object) { return bodies[member(object).index]; }
  const DeformableObject& body(int object) const { return bodies[member(object).index]; }
  bool is_body(int object) const { return object >= 0 && member(object).kind == ObjectKind::deformable; }
  int n_objects() const { return static_cast<int>(members.size()); }
  /// Object of a voxel number in the map.
  int object_of(VoxelId id) const;
  /// Object that occupies a cell; -1: the cell is free, or outside.
  int object_in(const Index3& cell);
  /// Voxel of its object for a number in the map.
  std::int64_t voxel_of(int object, VoxelId id) const;

  WorldScene scene;
  RigidWorld rigid;
  std::vector<Member> members;
  std::vector<DeformableObject> bodies; ///< empty in an open world: OpenBody has its own
  std::vector<int> by_number;           ///< objects in the order of their first voxel
  bool is_map_outdated = false;         ///< the map has rigid objects, but not the bodies yet

private:
  void check_apart() const;
  void add_rigid(int object);
  void add_body(int object);
};

/// @param other  object that an object would overlap initially; -1: none, it is outside the border
/// @throws std::invalid_argument
[[noreturn]] void fail_to_place(const WorldScene& scene, int object, int other);

} // namespace maille::deform
