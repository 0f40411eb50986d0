#include "world/occupancy/body_matter.hpp"

#include "lattice/tolerances.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <limits>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// Largest distance of adjacent nodes and points of a face before points are added between them [cells].
constexpr double closeness = 1.25;
/// Upper bound of the number of parts of a face, which is stored in 8 bits; far above any real one.
constexpr int most_parts = std::numeric_limits<std::int8_t>::max();

constexpr auto any_place = [](int, int) { return true; };

/// Number of parts of a face along each axis of the body: larger if the body is rotated.
Index3 parts_of_faces(const Specimen& specimen, const PosedLattice& lattice) {
  Index3 parts{1, 1, 1};
  const Vec3& spacing = specimen.grid.spacing();
  const Vec3& cell = lattice.cell_size();
  const int d = lattice.dimension();
  for (int a = 0; a < d; ++a) {
    const auto i = static_cast<std::size_t>(a);
    const double length = lattice.is_turned() ? std::sqrt(d - 1.0) * spacing[i] /
                                                    *std::min_element(cell.begin(), cell.begin() + d)
                                              : spacing[i] / cell[i];
    if (length > 1 + tolerance)
      parts[i] = static_cast<int>(std::ceil(closeness * length - tolerance));
  }
  return parts;
}

/// A box that certainly lies in a cell whose corners are near those of its bounding box: smaller by the
/// largest offset of a corner along each axis. On each of its sides the face of the cell is outside of it; a
/// continuous map with that property reaches every point between (theorem of Poincare and Miranda).
Eigen::AlignedBox3d surely_in_cell(std::span<const Eigen::Vector3d> corners, int dimension,
                                   const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  Eigen::AlignedBox3d inner(low, high);
  for (int a = 0; a < dimension; ++a) {
    double off = tolerance;
    for (std::size_t i = 0; i < corners.size(); ++i)
      off = std::max(off, (i >> a & 1U) != 0 ? high[a] - corners[i][a] : corners[i][a] - low[a]);
    inner.min()[a] += off;
    inner.max()[a] -= off;
  }
  return inner;
}

} // namespace

bool is_in_cell(std::span<const Eigen::Vector3d> corners, const Eigen::Vector3d& point, int dimension) {
  std::array<int, 3> axes{0, 1, 2};
  do {
    Eigen::Matrix3d edges = Eigen::Matrix3d::Identity();
    std::size_t corner = 0;
    for (int i = 0; i < dimension; ++i) {
      const std::size_t next = corner + (std::size_t{1} << axes[i]);
      edges.col(i).head(dimension) = (corners[next] - corners[corner]).head(dimension);
      corner = next;
    }
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    right.head(dimension) = (point - corners[0]).head(dimension);
    if (std::abs(edges.determinant()) > 0) {
      const Eigen::Vector3d t = edges.inverse() * right; // 1 >= t0 >= t1 >= t2 >= 0
      bool is_in = t[0] <= 1 + rounding && t[dimension - 1] >= -rounding;
      for (int i = 1; i < dimension; ++i)
        is_in = is_in && t[i - 1] >= t[i] - rounding;
      if (is_in)
        return true;
    }
  } while (std::next_permutation(axes.begin(), axes.begin() + dimension));
  return false;
}

BodyMatter::BodyMatter(const Specimen& specimen, const PosedLattice& lattice)
    : dimension_(lattice.dimension()), n_corners_(std::size_t{1} << lattice.dimension()) {
  const Grid& grid = specimen.grid;
  const Index3 parts = parts_of_faces(specimen, lattice);
  is_coarse_ = parts != Index3{1, 1, 1};
  const bool has_points = dimension_ > 1 && is_coarse_;
  Index3 fine{1, 1, 1};
  for (std::size_t a = 0; a < static_cast<std::size_t>(dimension_); ++a)
    fine[a] = grid.cells()[a] * parts[a] + 1;
  std::vector<bool> known(has_points ? static_cast<std::size_t>(std::int64_t{1} * fine[0] * fine[1] * fine[2])
                                     : std::size_t{0});
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    if (!specimen.is_matter(cell))
      continue;
    const Index3 at = grid.cell_at(cell);
    std::array<std::int32_t, 8>& corners = corners_.emplace_back();
    for (std::size_t corner = 0; corner < n_corners_; ++corner) {
      Index3 node = at;
      for (std::size_t a = 0; a < 3; ++a)
        node[a] += static_cast<int>(corner >> a & 1);
      corners[corner] = lattice.voxel(grid.node(node));
    }
    for (int axis = 0; dimension_ > 1 && axis < dimension_; ++axis)
      for (const bool upper : {false, true}) {
        Index3 beside = at;
        beside[axis] += upper ? 1 : -1;
        if (grid.has_cell(beside) && specimen.is_matter(grid.cell(beside)))
          continue;
        add_face(lattice, grid, parts, axis, upper, at);
        if (has_points)
          add_points(grid, parts, axis, upper, at, known);
      }
  }
}

void BodyMatter::add_face(const PosedLattice& lattice, const Grid& grid, const Index3& parts, int axis,
                          bool upper, const Index3& at) {
  const auto a = static_cast<std::size_t>(axis);
  const std::size_t b = (a + 1) % static_cast<std::size_t>(dimension_),
                    c = (a + 2) % static_cast<std::size_t>(dimension_);
  Face face{n_cells() - 1, {-1, -1, -1, -1}, {}};
  face.parts = {static_cast<std::int8_t>(std::min(parts[b], most_parts)),
                static_cast<std::int8_t>(dimension_ == 3 ? std::min(parts[c], most_parts) : 1)};
  for (std::size_t corner = 0; corner < (dimension_ == 3 ? 4u : 2u); ++corner) {
    Index3 node = at;
    node[a] += upper;
    node[b] += static_cast<int>(corner & 1);
    if (dimension_ == 3)
      node[c] += static_cast<int>(corner >> 1);
    face.node[corner] = lattice.voxel(grid.node(node));
  }
  faces_.push_back(face);
}

/// Number of parts of a face along its edges; 1, 1 if the parts at rest suffice.
/// @param places of a node, in each state
template<class... PlaceOf>
Index3 BodyMatter::stretched_parts(const Face& face, const PlaceOf&... places) const {
  Index3 needed{1, 1, 1};
  const std::size_t n = dimension_ == 3 ? 4 : 2;
  std::array<double, 2> longest{};
  bool is_open = false; // a whole cell of the world lies between two nodes
  const auto look_at = [&](const auto& place_of) {
    std::array<InCells, 4> place;
    for (std::size_t i = 0; i < n; ++i)
      place[i] = place_of(face.node[i]);
    const auto measure = [&](std::size_t i, std::size_t j, std::size_t along) {
      for (std::size_t a = 0; a < 3; ++a) {
        longest[along] = std::max(longest[along], std::abs(place[i][a] - place[j][a]));
        is_open = is_open || std::abs(std::floor(place[i][a]) - std::floor(place[j][a])) > face.parts[along];
      }
    };
    measure(0, 1, 0);
    if (n == 4) {
      measure(2, 3, 0);
      measure(0, 2, 1);
      measure(1, 3, 1);
    }
  };
  (look_at(places), ...);
  if (is_open || longest[0] > face.parts[0] * closeness || longest[1] > face.parts[1] * closeness)
    for (std::size_t i = 0; i < 2; ++i)
      needed[i] = static_cast<int>(std::clamp(std::ceil(closeness * longest[i]), 1.0, double{most_parts}));
  return needed;
}

/// Points between the nodes of a face, along its first edge, then its second.
/// @param is_wanted of a place, by its number along each edge
template<class IsWanted>
void BodyMatter::cut(const Face& face, int n_b, int n_c, const IsWanted& is_wanted,
                     std::vector<Point>& list) {
  const int last_c = face.node[2] >= 0 ? n_c : 0;
  for (int j = 0; j <= last_c; ++j)
    for (int i = 0; i <= n_b; ++i) {
      const bool is_node = i % n_b == 0 && (last_c == 0 || j % last_c == 0);
      if (is_node || !is_wanted(i, j))
        continue;
      Point point;
      point.cell = face.cell;
      const double u = static_cast<double>(i) / n_b, v = last_c > 0 ? static_cast<double>(j) / last_c : 0;
      for (std::size_t corner = 0; corner < (last_c > 0 ? 4u : 2u); ++corner) {
        point.node[corner] = face.node[corner];
        point.weight[corner] = ((corner & 1) != 0 ? u : 1 - u) * (last_c == 0         ? 1
                                                                  : (corner & 2) != 0 ? v
                                                                                      : 1 - v);
      }
      list.push_back(point);
    }
}

/// Points of the last face that no face before it had. @param known  by number among the points of all faces
void BodyMatter::add_points(const Grid& grid, const Index3& parts, int axis, bool upper, const Index3& at,
                            std::vector<bool>& known) {
  const auto a = static_cast<std::size_t>(axis), d = static_cast<std::size_t>(dimension_);
  const std::size_t b = (a + 1) % d, c = (a + 2) % d;
  const auto is_new = [&](int i, int j) {
    Index3 fine{0, 0, 0};
    for (std::size_t k = 0; k < d; ++k)
      fine[k] = at[k] * parts[k];
    fine[a] += upper ? parts[a] : 0;
    fine[b] += i;
    fine[c] += j;
    const auto number = static_cast<std::size_t>(
        fine[0] + (std::int64_t{1} * grid.cells()[0] * parts[0] + 1) *
                      (fine[1] + (std::int64_t{1} * grid.cells()[1] * parts[1] + 1) * std::int64_t{fine[2]}));
    const bool is_known = known[number];
    known[number] = true;
    return !is_known;
  };
  cut(faces_.back(), parts[b], parts[c], is_new, points_);
}

/// @param places of all nodes, in each state
template<class... Places>
std::vector<BodyMatter::Point> BodyMatter::points_of_stretched(const Places&... places) const {
  std::vector<Point> list;
  for (const Face& face : faces_)
    if (const Index3 parts = stretched_parts(face, [&](std::int32_t node) { return places[node]; }...);
        parts != Index3{1, 1, 1})
      cut(face, parts[0], parts[1], any_place, list);
  return list;
}

std::vector<BodyMatter::Point> BodyMatter::points_of_stretched(std::int32_t cell, const PosedLattice& lattice,
                                                               const Displacement& state) const {
  std::vector<Point> list;
  for (const Face& face : std::ranges::equal_range(faces_, cell, {}, &Face::cell))
    if (const Index3 parts =
            stretched_parts(face, [&](std::int32_t node) { return lattice.place(node, state); });
        parts != Index3{1, 1, 1})
      cut(face, parts[0], parts[1], any_place, list);
  return list;
}

bool BodyMatter::watch(const PosedLattice& lattice, const Displacement& from, const Displacement& to) {
  stretched_ = points_of_stretched(lattice.places(from), lattice.places(to));
  return !stretched_.empty();
}

std::pair<std::int32_t, std::int32_t> BodyMatter::points_of(std::int32_t cell) const {
  const auto range = std::ranges::equal_range(points_, cell, {}, &Point::cell);
  return {static_cast<std::int32_t>(range.begin() - points_.begin()),
          static_cast<std::int32_t>(range.end() - points_.begin())};
}

void BodyMatter::put(OccupancyMap& map, VoxelId first, std::span<const InCells> places) {
  const auto first_cell = static_cast<VoxelId>(first + std::ssize(places));
  const auto take_free = [&](const Index3& cell, std::int32_t number) {
    if (map.put(cell, first_cell + number))
      taken_.push_back(cell);
  };
  const auto take_at = [&](const Point& point) {
    const auto place_of = [&](std::int32_t node) { return places[node]; };
    if (const Index3 cell = cell_at(between_places(point, place_of)); map.has_cell(cell))
      take_free(cell, point.cell);
  };
  std::ranges::for_each(points_, take_at);
  std::ranges::for_each(points_of_stretched(places), take_at);
  std::array<Eigen::Vector3d, 8> at;
  for (std::int32_t number = 0; number < n_cells(); ++number) {
    Eigen::Vector3d low = Eigen::Vector3d::Constant(1e9), high = -low;
    const auto nodes = corners(number);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      at[i] = Eigen::Vector3d::Map(places[nodes[i]].data());
      low = low.cwiseMin(at[i]);
      high = high.cwiseMax(at[i]);
    }
    // If a cell of matter is no longer than cells of the world, every cell whose middle it contains also
    // contains a node.
    if (!is_coarse_ && (dimension_ == 1 || (high - low).head(dimension_).maxCoeff() <= 1 + tolerance))
      continue;
    const Eigen::AlignedBox3d inner =
        surely_in_cell(std::span(at).first(nodes.size()), dimension_, low, high);
    Index3 begin, end, cell;
    for (std::size_t a = 0; a < 3; ++a) {
      const auto i = static_cast<Eigen::Index>(a);
      begin[a] = static_cast<int>(std::clamp(std::ceil(low[i] - 0.5), 0.0, map.cells()[a] + 0.0));
      end[a] = static_cast<int>(std::clamp(std::floor(high[i] - 0.5), -1.0, map.cells()[a] - 1.0));
    }
    for (cell[2] = begin[2]; cell[2] <= end[2]; ++cell[2])
      for (cell[1] = begin[1]; cell[1] <= end[1]; ++cell[1])
        for (cell[0] = begin[0]; cell[0] <= end[0]; ++cell[0])
          if (const Eigen::Vector3d middle(cell[0] + 0.5, cell[1] + 0.5, cell[2] + 0.5);
              inner.contains(middle) || (!map.is_occupied(cell) && is_in_cell(at, middle, dimension_)))
            take_free(cell, number);
  }
}

void BodyMatter::take(OccupancyMap& map) {
  for (const Index3& cell : taken_)
    map.take(cell);
  taken_.clear();
}

std::int64_t BodyMatter::bytes() const {
  return static_cast<std::int64_t>(
      corners_.capacity() * sizeof(corners_[0]) + faces_.capacity() * sizeof(Face) +
      (points_.capacity() + stretched_.capacity()) * sizeof(Point) + taken_.capacity() * sizeof(Index3));
}

} // namespace maille::deform
