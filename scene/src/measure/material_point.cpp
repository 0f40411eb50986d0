#include "measure/material_point.hpp"

#include <algorithm>
#include <cmath>

namespace maille {

namespace {

/// In cells from node 0 along an axis; a point that a viewer shows on a border is on it, as of regions.
double in_cells(const Specimen& body, const Vec3& place, std::size_t axis) {
  constexpr double tolerance = 1e-4;
  const double at = (place[axis] - body.origin[axis]) / body.grid.spacing()[axis];
  return std::abs(at - std::round(at)) < tolerance ? std::round(at) : at;
}

} // namespace

MaterialPoint located(const Specimen& body, const Vec3& place) {
  const auto d = static_cast<std::size_t>(body.grid.dimension());
  Index3 low{}, high{};
  for (std::size_t a = 0; a < d; ++a) {
    const double at = in_cells(body, place, a), n = body.grid.cells()[a];
    if (!(at >= 0 && at <= n))
      return {place, {}};
    high[a] = static_cast<int>(std::min(std::floor(at), n - 1));
    low[a] = static_cast<int>(std::max(std::ceil(at) - 1, 0.0));
  }
  MaterialPoint point{place, {}};
  for (std::size_t a = 0; a < d; ++a) // on the border of finer lattices, too
    if (const double at = in_cells(body, place, a); at == std::round(at))
      point.place[a] = body.origin[a] + at * body.grid.spacing()[a];
  for (int k = low[2]; k <= high[2]; ++k)
    for (int j = low[1]; j <= high[1]; ++j)
      for (int i = low[0]; i <= high[0]; ++i)
        if (const std::int64_t cell = body.grid.cell({i, j, k}); body.is_matter(cell))
          point.cells.push_back(cell);
  return point;
}

Vec3 displacement_at(const Specimen& body, const Displacement& u, const MaterialPoint& point) {
  const Grid& grid = body.grid;
  const Index3 cell = grid.cell_at(point.cells.front());
  Vec3 value{};
  for (int corner = 0; corner < grid.corners_per_cell(); ++corner) {
    double weight = 1;
    for (int a = 0; a < grid.dimension(); ++a) {
      const auto axis = static_cast<std::size_t>(a);
      const double upper = in_cells(body, point.place, axis) - cell[axis];
      weight *= corner >> a & 1 ? upper : 1 - upper;
    }
    for (int b = 0; b < grid.dimension() && weight != 0; ++b)
      value[static_cast<std::size_t>(b)] += weight * u(b, grid.corner(cell, corner));
  }
  return value;
}

} // namespace maille
