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
/// Where faces of a cell of matter are longer than cells of the world, as it stands, or the body is turned,
/// cells of the world whose middles lie in it, or that a point of its surface lies in, are the body's where
/// they are free; elsewhere nodes take all of them. In the map they have the number of the cell of matter,
/// counted on from the body's last node. Points of the surface are followed like nodes: where faces are
/// longer than cells at rest they are at most 4/5 of a cell apart then; where a face is stretched so that two
/// of its nodes or points come further apart than 5/4 of a cell, it gets others, 4/5 of a cell apart, for
/// as long as that lasts (watch). So nothing as large as a cell comes between them.
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
    std::array<double, 4> weight{};     ///< 0 where there are fewer
    std::int32_t cell = 0;              ///< of matter
  };
  /// Those of stretched faces follow the others.
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
  /// Gives points to the faces that are stretched in either of two states, in place of those that it gave
  /// before. @return whether there are any
  bool watch(const PosedLattice& lattice, const Displacement& from, const Displacement& to);
  /// Points of a cell of matter that it has at rest: the first and the one after the last.
  std::pair<std::int32_t, std::int32_t> points_of(std::int32_t cell) const;

  /// Those that stretched faces of a cell of matter have in a state.
  std::vector<Point> points_of_stretched(std::int32_t cell, const PosedLattice& lattice,
                                         const Displacement& state) const;
  /// A face of a cell of matter with no matter behind it; its nodes by the bits of its two axes, the one
  /// after its normal's first. There are none in one dimension.
  struct Face {
    std::int32_t cell;
    std::array<std::int32_t, 4> node; ///< -1 where there are fewer: two in 2D
    std::array<std::int8_t, 2> parts; ///< that it is cut into at rest, along its first and second edges
  };
  std::span<const Face> faces() const { return faces_; }

  /// Takes the free cells that are the body's. @pre it has none, and its nodes have theirs
  /// @param places of all nodes of the lattice
  void put(OccupancyMap& map, VoxelId first, std::span<const InCells> places);
  void take(OccupancyMap& map);
  /// What it has taken is not in the map any more.
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
  bool is_coarse_ = false; ///< longer faces than cells of the world: there are cells between nodes at rest
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
