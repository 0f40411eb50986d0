#include "read/reader.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace maille::reader {

namespace {

/// Centre of a cell along an axis, from -1 at the lower end of the grid to 1 at the upper.
double relative_centre(const Grid& grid, const Index3& cell, std::size_t axis) {
  return 2 * (cell[axis] + 0.5) / grid.cells()[axis] - 1;
}

} // namespace

std::vector<std::uint8_t> ellipsoid_cells(const Grid& grid) {
  std::vector<std::uint8_t> cells(static_cast<std::size_t>(grid.n_cells()), no_material);
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    double radius_sq = 0;
    for (int axis = 0; axis < grid.dimension(); ++axis) {
      const double c = relative_centre(grid, grid.cell_at(cell), static_cast<std::size_t>(axis));
      radius_sq += c * c;
    }
    if (radius_sq <= 1)
      cells[static_cast<std::size_t>(cell)] = 0;
  }
  return cells;
}

std::vector<std::uint8_t> muscle_cells(const Grid& grid, double tendon_fraction) {
  constexpr double end_radius = 0.35; // of the widest, where the tendon leaves the grid
  std::vector<std::uint8_t> cells(static_cast<std::size_t>(grid.n_cells()), no_material);
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    const Index3 at = grid.cell_at(cell);
    const double along = (at[0] + 0.5) / grid.cells()[0];
    const double swell = std::sin(std::numbers::pi * along);
    const double radius = end_radius + (1 - end_radius) * swell * swell;
    double distance_sq = 0;
    for (std::size_t axis = 1; axis < static_cast<std::size_t>(grid.dimension()); ++axis)
      distance_sq += std::pow(relative_centre(grid, at, axis), 2);
    if (distance_sq <= radius * radius)
      cells[static_cast<std::size_t>(cell)] = along < tendon_fraction || along > 1 - tendon_fraction ? 1 : 0;
  }
  return cells;
}

} // namespace maille::reader
