#pragma once
/// What the nodes of a deformable object meet on their way from one state to another.

#include "world/occupancy/body_matter.hpp"
#include "world/occupancy/node_cells.hpp"
#include "world/occupancy/posed_lattice.hpp"

#include <vector>

namespace maille::deform {

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
