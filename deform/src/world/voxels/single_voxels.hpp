#pragma once
/// The voxels of a world one by one, as Gibson 1995 moves them: `method = "hand_on"`.

#include "lattice/link_table.hpp"
#include "world/voxels/hand_on.hpp"
#include "world/world_parts.hpp"

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <vector>

namespace maille::deform {

/// Whether a world can be moved voxel by voxel: its objects stand straight, what is fixed or rigid has the
/// world's spacing, every voxel has a cell of its own, holds keep all of a node, there is no friction and no
/// other law of contact.
/// @throws std::invalid_argument naming the object
void check_single_voxels(const WorldParts& parts);

/// Every node and every voxel of a rigid or fixed object has one cell, and a cell one of them. What a voxel
/// cannot do of a movement it hands on to the one in its way (hand_on), of whatever object. Nodes of a body
/// are joined by nothing but the sweeps that follow: limits are what they come back to, not what they keep.
///
/// Fixed are: fixed objects, held nodes, nodes in a hand, rigid objects of several voxels, and of one where a
/// hand has it.
class SingleVoxels {
public:
  /// As the world is.
  /// @throws std::invalid_argument where two voxels are in one cell
  explicit SingleVoxels(const WorldParts& parts);

  struct Voxel {
    int object = -1; ///< -1: the border of the world
    std::int64_t voxel = 0;
  };
  /// Movement that one voxel handed on to the next, or could not.
  struct Handed {
    Voxel from, to;
    Eigen::Vector3d asked = Eigen::Vector3d::Zero(), moved = Eigen::Vector3d::Zero(); ///< [cells]
  };

  /// Moves nodes of a body, those in front first. @param by of each [cells]
  void move_nodes(int object, const std::vector<std::int64_t>& nodes, const std::vector<Eigen::Vector3d>& by);
  /// Moves a rigid object as a whole. What its voxels meet is handed the rest of the movement, once; then it
  /// goes as far as its way is free. @param by at most a cell along any axis [cells] @return the part
  double move_rigid(int object, const Eigen::Vector3d& by);
  /// One sweep over a body: every free node goes to the mean of its linked neighbours within its limits, or
  /// between limits that contradict each other. @return how far any went [cells]
  double sweep(int object);

  /// Transfers since the last call.
  std::vector<Handed> take_handed();
  /// Poses and displacements of the world, as they are here.
  void hand_back(WorldParts& parts) const;

private:
  struct Body {
    LinkTable table;
    std::vector<Eigen::Vector3d> rest; ///< [cells]
    bool is_elastic;
  };

  VoxelId first(int object) const { return first_[static_cast<std::size_t>(object)]; }
  FreeVoxel& voxel(VoxelId id) { return voxels_[static_cast<std::size_t>(id)]; }
  Voxel whose(VoxelId id) const;
  void add_rigid(const WorldParts& parts, int object);
  void add_body(const WorldParts& parts, int object);
  Eigen::Vector3d go(VoxelId id, const Eigen::Vector3d& by);
  struct Obstruction {
    double time;
    VoxelId voxel; ///< the empty id: the border
  };
  std::optional<Obstruction> in_the_way(int object, VoxelId id, const Eigen::Vector3d& by) const;
  Eigen::Vector3d gone(int object) const;

  const WorldParts& parts_;
  Eigen::Vector3d cell_size_;
  OccupancyMap map_;
  std::vector<FreeVoxel> voxels_;
  std::vector<VoxelId> first_;         ///< by object, and the end
  std::vector<Body> bodies_;           ///< as in the world
  std::vector<Eigen::Vector3d> start_; ///< by object, of the first voxel [cells]
  std::vector<Handed> handed_;
};

} // namespace maille::deform
