#pragma once
/// Matter between the nodes of a deformable object.

#include "maille/deform/world/occupancy_map.hpp"
#include "maille/scene/scene.hpp"
#include "world/occupancy/node_cells.hpp"
#include "world/occupancy/posed_lattice.hpp"

#include <span>
#include <vector>

namespace maille::deform {

/// True if a point is in a cell of a body with displaced corners. The cell is divided into simplices about
/// one diagonal (Kuhn 1960), so that adjacent cells have no gap between them. @param corners 2^dimension, x
/// fastest
bool is_in_cell(std::span<const Eigen::Vector3d> corners, const Eigen::Vector3d& point, int dimension);

/// The cells of matter of a body, and points of its surface between nodes.
///
/// The body occupies free cells of the world whose middle lies in a cell of matter, or that contain a point
/// of its surface. They are needed only if faces of a cell of matter are now longer than cells of the world,
/// or if the body is rotated; otherwise its nodes occupy all cells. In the map these cells have the number of
/// the cell of matter, counted after the body's last node. Points of the surface are followed like nodes. If
/// faces are longer than cells at rest, their points are at most 4/5 of a cell apart at rest. If two nodes or
/// points of a face come more than 5/4 of a cell apart, or lie in cells that do not touch, the face receives
/// other points, 4/5 of a cell apart, as long as that lasts (watch). No obstacle as large as a cell can pass
/// between them.
class BodyMatter {
public:
  BodyMatter(const Specimen& specimen, const PosedLattice& lattice);

  std::int32_t n_cells() const { return static_cast<std::int32_t>(corners_.size()); }
  std::int32_t n_points() const {
    return static_cast<std::int32_t>(points_.size()) + static_cast<std::int32_t>(stretched_.size());
  }
  /// The corners of a cell of matter, nodes of the lattice, x fastest. @return 2^dimension
  std::span<const std::int32_t> corners(std::int32_t cell) const {
    return std::span(corners_[cell]).first(n_corners_);
  }
  /// A point between the corners of a face.
  struct Point {
    std::array<std::int32_t, 4> node{}; ///< of the lattice
    std::array<double, 4> weight{};     ///< 0 for unused corners
    std::int32_t cell = 0;              ///< of matter
  };
  /// A point; points of stretched faces have the numbers after the others.
  const Point& point(std::int32_t number) const {
    const auto i = static_cast<std::size_t>(number);
    return i < points_.size() ? points_[i] : stretched_[i - points_.size()];
  }
  InCells place(const Point& between, const PosedLattice& lattice, const Displacement& displacement) const {
    return between_places(between, [&](std::int32_t node) { return lattice.place(node, displacement); });
  }
  InCells place(std::int32_t number, const PosedLattice& lattice, const Displacement& displacement) const {
    return place(point(number), lattice, displacement);
  }
  /// Adds points to the faces that are stretched in either of two states, and removes those added before.
  /// @return true if there are any
  bool watch(const PosedLattice& lattice, const Displacement& from, const Displacement& to);
  /// Points of a cell of matter at rest: first number and end.
  std::pair<std::int32_t, std::int32_t> points_of(std::int32_t cell) const;

  /// Points of the stretched faces of a cell of matter in a state.
  std::vector<Point> points_of_stretched(std::int32_t cell, const PosedLattice& lattice,
                                         const Displacement& state) const;
  /// An outer face of a cell of matter. The bits of a node's index are its two axes, the one after the normal
  /// first. None in one dimension.
  struct Face {
    std::int32_t cell;
    std::array<std::int32_t, 4> node; ///< in 2D two, then -1
    std::array<std::int8_t, 2> parts; ///< at rest, along its first and second edges
  };
  std::span<const Face> faces() const { return faces_; }

  /// Occupies the free cells of the body. @pre it has none yet, and its nodes are in the map
  /// @param places of all nodes of the lattice
  void put(OccupancyMap& map, VoxelId first, std::span<const InCells> places);
  void take(OccupancyMap& map);
  /// Forgets its cells, after they were removed from the map.
  void forget() { taken_.clear(); }
  std::int64_t bytes() const;

private:
  void add_face(const PosedLattice& lattice, const Grid& grid, const Index3& parts, int axis, bool upper,
                const Index3& at);
  template<class PlaceOf>
  InCells between_places(const Point& between, const PlaceOf& place_of) const;
  template<class... PlaceOf>
  Index3 stretched_parts(const Face& face, const PlaceOf&... places) const;
  template<class IsWanted>
  static void cut(const Face& face, int n_b, int n_c, const IsWanted& is_wanted, std::vector<Point>& list);
  template<class... Places>
  std::vector<Point> points_of_stretched(const Places&... places) const;
  void add_points(const Grid& grid, const Index3& parts, int axis, bool upper, const Index3& at,
                  std::vector<bool>& known);

  int dimension_;
  bool is_coarse_ = false; ///< faces are longer than cells of the world: nodes at rest do not reach all cells
  std::size_t n_corners_;
  std::vector<std::array<std::int32_t, 8>> corners_;
  std::vector<Face> faces_;
  std::vector<Point> points_, stretched_;
  std::vector<Index3> taken_;
};

/// @param place_of  of a node of the lattice
template<class PlaceOf>
InCells BodyMatter::between_places(const Point& between, const PlaceOf& place_of) const {
  InCells sum{0.5, 0.5, 0.5};
  for (std::size_t a = 0; a < static_cast<std::size_t>(dimension_); ++a)
    sum[a] = 0;
  for (std::size_t i = 0; i < 4; ++i)
    if (between.weight[i] > 0) {
      const InCells place = place_of(between.node[i]);
      for (std::size_t a = 0; a < static_cast<std::size_t>(dimension_); ++a)
        sum[a] += between.weight[i] * place[a];
    }
  return sum;
}

} // namespace maille::deform
