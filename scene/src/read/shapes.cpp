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

Index3 crop_to_matter(Specimen& body) {
  const Grid& grid = body.grid;
  Index3 low = grid.cells(), high{-1, -1, -1};
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    if (!body.is_matter(cell))
      continue;
    const Index3 at = grid.cell_at(cell);
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], at[a]);
      high[a] = std::max(high[a], at[a]);
    }
  }
  Index3 size{};
  for (std::size_t a = 0; a < 3; ++a)
    size[a] = high[a] - low[a] + 1;
  if (size == grid.cells())
    return low;
  Specimen cropped = body;
  cropped.grid = Grid(grid.dimension(), size, grid.spacing());
  cropped.material_id.clear();
  cropped.fibres.clear();
  cropped.label.clear();
  for (std::int64_t cell = 0; cell < cropped.grid.n_cells(); ++cell) {
    Index3 at = cropped.grid.cell_at(cell);
    for (std::size_t a = 0; a < 3; ++a)
      at[a] += low[a];
    const auto from = static_cast<std::size_t>(grid.cell(at));
    cropped.material_id.push_back(body.material_id[from]);
    if (!body.fibres.empty())
      cropped.fibres.push_back(body.fibres[from]);
    if (!body.label.empty())
      cropped.label.push_back(body.label[from]);
  }
  for (std::size_t a = 0; a < 3; ++a)
    cropped.origin[a] += low[a] * grid.spacing()[a];
  body = std::move(cropped);
  return low;
}

} // namespace maille::reader
