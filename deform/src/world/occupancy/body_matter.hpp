#pragma once
/// What lies between the nodes of a deformable object.

#include "maille/deform/world/occupancy_map.hpp"
#include "maille/scene/scene.hpp"
#include "world/occupancy/node_cells.hpp"
#include "world/occupancy/posed_lattice.hpp"

#include <span>
#include <vector>

namespace maille::deform {

/// Whether a point is in a cell of a body whose corners stand anywhere, cut into simplices about one diagonal
/// (Kuhn 1960), so that cells beside one another have no gap between them. @param corners 2^dimension, x
/// fastest
bool is_in_cell(std::span<const Eigen::Vector3d> corners, const Eigen::Vector3d& point, int dimension);

/// The cells of matter of a body, and points of its surface between nodes.
///
/// Of a body whose faces are longer than cells of the world, or that is turned, cells whose middles lie in
/// its matter, or that a point of its surface lies in, are the body's where they are free; of others nodes
/// take all of them, as long as it is not stretched. In the map they have the number of the cell of matter,
/// counted on from the body's last node. Points of the surface are followed like nodes; there are such where
/// faces are longer than cells of the world, at most 4/5 of a cell apart at rest, so nothing as large as a
/// cell comes between them until they are stretched to 5/4.
class BodyMatter {
public:
  BodyMatter(const Specimen& specimen, const PosedLattice& lattice);

  std::int32_t n_cells() const { return static_cast<std::int32_t>(corners_.size()); }
  std::int32_t n_points() const { return static_cast<std::int32_t>(points_.size()); }
  /// The corners of a cell of matter, nodes of the lattice, x fastest. @return 2^dimension
  std::span<const std::int32_t> corners(std::int32_t cell) const {
    return std::span(corners_[static_cast<std::size_t>(cell)]).first(n_corners_);
  }
  /// A point between the corners of a face.
  struct Point {
    std::array<std::int32_t, 4> node{}; ///< of the lattice
    std::array<double, 4> weight{};     ///< 0 where there are fewer
    std::int32_t cell = 0;              ///< of matter
  };
  const Point& point(std::int32_t number) const { return points_[static_cast<std::size_t>(number)]; }
  InCells place(std::int32_t point, const PosedLattice& lattice, const Displacement& displacement) const;
  /// Points of a cell of matter: the first and the one after the last.
  std::pair<std::int32_t, std::int32_t> points_of(std::int32_t cell) const;

  /// Takes the free cells that are the body's. @pre it has none, and its nodes have theirs
  void put(OccupancyMap& map, VoxelId first, const PosedLattice& lattice, const Displacement& displacement);
  void take(OccupancyMap& map);
  std::int64_t bytes() const;

private:
  void add_points(const Specimen& specimen, const PosedLattice& lattice, const Index3& parts, int axis,
                  bool upper, const Index3& at, std::vector<bool>& known);

  int dimension_;
  bool is_coarse_ = false; ///< longer faces than cells of the world: there are cells between nodes at rest
  std::size_t n_corners_;
  std::vector<std::array<std::int32_t, 8>> corners_;
  std::vector<Point> points_;
  std::vector<Index3> taken_;
};

} // namespace maille::deform
