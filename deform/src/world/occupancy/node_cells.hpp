#pragma once
/// The cells that the nodes of one deformable object take, and what they meet on their way from one state to
/// another.

#include "maille/deform/world/occupancy_map.hpp"
#include "world/occupancy/posed_lattice.hpp"

#include <cstdint>
#include <vector>

namespace maille::deform {

class BodyMatter;

/// Keeps an occupancy map in step with the nodes of one object, at the cost of those that change their cell.
///
/// The map holds one number a cell. Where several nodes lie in one cell it is the smallest, and the others
/// follow it in a chain in the order of their numbers, so that the map depends on where the nodes are, not on
/// how they came there. A node costs a walk along the chains of the cells that it leaves and enters.
class NodeCells {
public:
  /// No node is anywhere yet. @param first the number of node 0 in the map @param n_others numbers after
  /// those of nodes that are the object's too
  NodeCells(VoxelId first, std::int32_t n_voxels, std::int32_t n_others = 0)
      : first_(first), n_ids_(n_voxels + n_others), cells_(static_cast<std::size_t>(n_voxels)),
        next_(static_cast<std::size_t>(n_voxels), -1) {}

  VoxelId first() const { return first_; }
  /// How many numbers are the object's.
  std::int32_t n_ids() const { return n_ids_; }
  bool is_own(VoxelId id) const { return id >= first_ && id - first_ < n_ids_; }
  /// Whether a number of the object's is a node's.
  bool is_node(VoxelId id) const { return id - first_ < static_cast<VoxelId>(cells_.size()); }
  std::int32_t voxel(VoxelId id) const { return id - first_; }
  const Index3& cell(std::int32_t voxel) const { return cells_[voxel]; }
  /// Whether a node cannot go there: another object's, or outside the world.
  bool is_blocked(const OccupancyMap& map, const Index3& cell) const {
    return map.is_blocked(cell) && (!map.has_cell(cell) || !is_own(map.occupant(cell)));
  }
  /// @pre not is_blocked(map, cell); the node is nowhere
  void put(OccupancyMap& map, std::int32_t voxel, const Index3& cell);
  /// @pre not is_blocked(map, cell)
  void move(OccupancyMap& map, std::int32_t voxel, const Index3& cell);
  /// All nodes in a cell that belongs to this object, in order; none where there is matter between nodes
  /// alone.
  std::vector<std::int32_t> voxels_in(const OccupancyMap& map, const Index3& cell) const;
  std::int64_t bytes() const {
    return static_cast<std::int64_t>(cells_.capacity() * sizeof(Index3) +
                                     next_.capacity() * sizeof(std::int32_t));
  }

private:
  std::int32_t& next(std::int32_t voxel) { return next_[voxel]; }
  void take(OccupancyMap& map, std::int32_t voxel);

  VoxelId first_;
  std::int32_t n_ids_;
  std::vector<Index3> cells_;
  std::vector<std::int32_t> next_; ///< in the same cell, -1 at the end
};

/// Where a node, or a point of the surface between nodes, would enter a cell that it cannot enter.
struct Hit {
  std::int32_t voxel = 0; ///< a node; from the number of nodes on: a point
  double time = 0;        ///< of the way, 0 to 1
  int axis = 0;           ///< of the face
  int direction = 1;      ///< -1 or 1
  Index3 wall{};          ///< the cell
  double rest = 0;        ///< of the movement along the axis, behind the face, signed [cells]
  double speed = 0;       ///< |movement along the axis| on the whole way [cells]
};

/// The first such cell of every node that meets one, in the order of the nodes, then of points. Cells are
/// followed one after another through faces (see CellWalk); all nodes go along straight lines at the same
/// time from 0 to 1.
/// Cost  a look at every node that moves, and one at each cell that it enters
std::vector<Hit> find_hits(const OccupancyMap& map, const NodeCells& cells, const PosedLattice& lattice,
                           const BodyMatter& matter, const Displacement& from, const Displacement& to);

} // namespace maille::deform
