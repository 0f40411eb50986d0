#include "trade/lattices.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace maille::studies {

namespace {

/// Finds the cell that contains a point, or the nearest one.
class NearestMatter {
public:
  explicit NearestMatter(const Specimen& body) : body_(body), grid_(body.grid) {}

  /// @param place  position in cells from node 0, along every axis
  Index3 operator()(const Vec3& place) const {
    Index3 home{};
    int furthest = 1;
    for (std::size_t a = 0; a < 3; ++a) {
      home[a] = std::clamp(static_cast<int>(std::floor(place[a])), 0, grid_.cells()[a] - 1);
      furthest = std::max(furthest, grid_.cells()[a]);
    }
    if (body_.is_matter(grid_.cell(home)))
      return home;
    Index3 nearest = home;
    double least_sq = std::numeric_limits<double>::infinity();
    for (int ring = 1; ring <= furthest; ++ring) {
      search_ring(place, home, ring, nearest, least_sq);
      if (least_sq <= static_cast<double>(ring) * ring) // cells of the next ring are at least this far
        break;
    }
    return nearest;
  }

private:
  double distance_sq(const Vec3& place, const Index3& cell) const {
    double sum = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      const double outside = std::max({cell[a] - place[a], place[a] - cell[a] - 1, 0.0});
      sum += outside * outside;
    }
    return sum;
  }

  /// Searches the cells whose index differs from home's by exactly `ring` along some axis, and by no more
  /// along the others.
  void search_ring(const Vec3& place, const Index3& home, int ring, Index3& nearest, double& least_sq) const {
    Index3 low{}, high{};
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::max(0, home[a] - ring);
      high[a] = std::min(grid_.cells()[a] - 1, home[a] + ring);
    }
    for (int k = low[2]; k <= high[2]; ++k)
      for (int j = low[1]; j <= high[1]; ++j)
        for (int i = low[0]; i <= high[0]; ++i) {
          const Index3 at{i, j, k};
          const int away = std::max({std::abs(i - home[0]), std::abs(j - home[1]), std::abs(k - home[2])});
          if (away != ring || !body_.is_matter(grid_.cell(at)))
            continue;
          if (const double d = distance_sq(place, at); d < least_sq) {
            least_sq = d;
            nearest = at;
          }
        }
  }

  const Specimen& body_;
  const Grid& grid_;
};

} // namespace

Displacement between_lattices(const Scene& from, const Displacement& displacement, const Scene& to) {
  const Grid &grid = from.specimen.grid, &target = to.specimen.grid;
  const NearestMatter nearest(from.specimen);
  Displacement result(target);
  for (std::int64_t node = 0; node < target.n_nodes(); ++node) {
    const Index3 at = target.node_at(node);
    if (!to.specimen.is_node(at))
      continue;
    const Vec3 x = to.specimen.position(at);
    Vec3 place{};
    for (int a = 0; a < grid.dimension(); ++a) {
      place[a] = (x[a] - from.specimen.origin[a]) / grid.spacing()[a];
      if (const double whole = std::round(place[a]);
          std::abs(place[a] - whole) < 1e-9 * (1 + std::abs(whole)))
        place[a] = whole; // common nodes keep their bits
    }
    const Index3 cell = nearest(place);
    for (int corner = 0; corner < grid.corners_per_cell(); ++corner) {
      double weight = 1;
      for (int a = 0; a < grid.dimension(); ++a) {
        const double upper = place[a] - cell[a];
        weight *= corner >> a & 1 ? upper : 1 - upper;
      }
      if (weight == 0)
        continue;
      for (int c = 0; c < grid.dimension(); ++c)
        result(c, node) += weight * displacement(c, grid.corner(cell, corner));
    }
  }
  return result;
}

} // namespace maille::studies
