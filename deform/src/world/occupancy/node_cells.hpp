#pragma once
/// Cells occupied by the nodes of one deformable object, and their collisions on the way from one state to
/// another.

#include "maille/deform/world/occupancy_map.hpp"
#include "world/occupancy/posed_lattice.hpp"

#include <cstdint>
#include <vector>

namespace maille::deform {

class BodyMatter;

/// Updates an occupancy map with the nodes of one object, at the cost of the nodes that change their cell.
///
/// The map has one number per cell. If several nodes lie in one cell it is the smallest, and the others
/// follow in a chain sorted by number, so that the map depends only on the positions of the nodes. Moving a
/// node costs a walk along the chains of the cells that it leaves and enters.
class NodeCells {
public:
  /// Starts without nodes in the map. @param first the number of node 0 in the map @param n_others further
  /// numbers of the object after those of nodes
  NodeCells(VoxelId first, std::int32_t n_voxels, std::int32_t n_others = 0)
      : first_(first), n_ids_(n_voxels + n_others), cells_(static_cast<std::size_t>(n_voxels)),
        next_(static_cast<std::size_t>(n_voxels), -1) {}

  VoxelId first() const { return first_; }
  /// Count of the object's numbers.
  std::int32_t n_ids() const { return n_ids_; }
  bool is_own(VoxelId id) const { return id >= first_ && id - first_ < n_ids_; }
  /// True if a number of the object belongs to a node.
  bool is_node(VoxelId id) const { return id - first_ < static_cast<VoxelId>(cells_.size()); }
  std::int32_t voxel(VoxelId id) const { return id - first_; }
  const Index3& cell(std::int32_t voxel) const { return cells_[voxel]; }
  /// True if a node cannot enter a cell: it belongs to another object, or is outside the world.
  bool is_blocked(const OccupancyMap& map, const Index3& cell) const {
    return map.is_blocked(cell) && (!map.has_cell(cell) || !is_own(map.occupant(cell)));
  }
  /// @pre not is_blocked(map, cell); the node is not in the map
  void put(OccupancyMap& map, std::int32_t voxel, const Index3& cell);
  /// @pre not is_blocked(map, cell)
  void move(OccupancyMap& map, std::int32_t voxel, const Index3& cell);
  /// All nodes in a cell of this object, sorted; none if the cell only has matter between nodes.
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
  std::vector<std::int32_t> next_; ///< next node in the same cell; -1: last
};

/// Collision: a node, or a point of the surface between nodes, would enter a blocked cell.
struct Hit {
  std::int32_t voxel = 0; ///< a node; numbers from the count of nodes on: points
  double time = 0;        ///< of the way, 0 to 1
  int axis = 0;           ///< of the face
  int direction = 1;      ///< -1 or 1
  Index3 wall{};          ///< the cell
  double rest = 0;        ///< remaining movement along the axis beyond the face, signed [cells]
  double speed = 0;       ///< |movement along the axis| of the whole path [cells]
};

/// The first collision of every node, in the order of the nodes, then of points. Paths are followed from cell
/// to cell through faces (see CellWalk); all nodes move along straight lines over a time from 0 to 1.
/// Cost  a test for every moving node and for each cell that it enters
std::vector<Hit> find_hits(const OccupancyMap& map, const NodeCells& cells, const PosedLattice& lattice,
                           const BodyMatter& matter, const Displacement& from, const Displacement& to);

} // namespace maille::deform
