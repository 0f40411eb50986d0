#pragma once
/// What a world is made of.

#include "maille/deform/world/world.hpp"
#include "world/deformable_object.hpp"
#include "world/lone_body.hpp"

#include <map>
#include <memory>
#include <tuple>
#include <vector>

namespace maille::deform {

class Balance;
class Dynamics;
class SoftDynamics;

struct WorldParts {
  explicit WorldParts(WorldScene scene);
  ~WorldParts();
  /// A copy of a world that is not open, and whose objects are kept apart by cells.
  WorldParts(const WorldParts& other);
  /// A copy of an open one with that copy of its body.
  WorldParts(const WorldParts& other, LoneBody body);

  struct Member {
    ObjectKind kind;
    int index;                 ///< among rigid and fixed objects, or among bodies
    VoxelId first;             ///< of its voxels in the map
    bool is_driven = false;    ///< a hand has it
    bool is_unsettled = false; ///< a frame ended before it had come to rest
  };

  /// With all bodies where they are.
  OccupancyMap& map() {
    if (map_is_behind) {
      map_is_behind = false;
      for (DeformableObject& body : bodies)
        body.put_into(rigid.map_of_all());
    }
    return rigid.map_of_all();
  }
  const Member& member(int object) const { return members[static_cast<std::size_t>(object)]; }
  Member& member(int object) { return members[static_cast<std::size_t>(object)]; }
  DeformableObject& body(int object) { return bodies[static_cast<std::size_t>(member(object).index)]; }
  const DeformableObject& body(int object) const {
    return bodies[static_cast<std::size_t>(member(object).index)];
  }
  bool is_body(int object) const { return object >= 0 && member(object).kind == ObjectKind::deformable; }
  int n_objects() const { return static_cast<int>(members.size()); }
  /// Object with a voxel in a cell; -1: the cell is free, or outside.
  int object_in(const Index3& cell);
  /// Which voxel of its object a number in the map means.
  std::int64_t voxel_of(int object, VoxelId id) const;

  /// Effect of earlier pushes on the faces between two objects along an axis.
  struct Push {
    double change = 0; ///< of the imbalance of pressures by one push, as far as that is known [N]
    /// The imbalance before the last push of this step, towards the object with the higher number [N]
    std::optional<double> before;
    int n = 0; ///< pushes in this step
  };

  WorldScene scene;
  RigidWorld rigid;
  std::vector<Member> members;
  std::vector<DeformableObject> bodies;
  std::optional<LoneBody> lone; ///< of an open world, which has no others
  /// Pushes by the objects' numbers, the lower first, and the axis.
  std::map<std::tuple<int, int, int>, Push> pushes;
  std::vector<int> by_number; ///< objects in the order of their first voxel
  /// Rigid objects have been put into the map anew and bodies not: surfaces ask for no map, only who looks.
  bool map_is_behind = false;
  std::unique_ptr<Balance> balance;            ///< of surfaces; null where cells keep objects apart
  std::unique_ptr<Dynamics> dynamics;          ///< of rigid objects alone; null where no time passes
  std::unique_ptr<SoftDynamics> soft_dynamics; ///< where some are deformable

private:
  void check_apart() const;
  void add_rigid(int object);
  void add_body(int object);
};

/// @param other  whose place an object would take as the world begins; -1: no one's, beyond the border
/// @throws std::invalid_argument
[[noreturn]] void fail_to_place(const WorldScene& scene, int object, int other);

} // namespace maille::deform
