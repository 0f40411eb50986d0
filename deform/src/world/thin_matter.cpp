/// Detection of matter thinner than the cells of its world.

#include "lattice/tolerances.hpp"
#include "maille/deform/world/world.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace maille::deform {

namespace {

using Mask = std::vector<std::uint8_t>;

/// The minimum (erosion) or maximum (dilation) of n values along an axis at every place: of those starting at
/// it, or those ending at it.
Mask along(const Mask& mask, const Grid& grid, int axis, int n, bool is_erosion) {
  const auto a = static_cast<std::size_t>(axis);
  Mask result(mask.size());
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    Index3 at = grid.cell_at(cell);
    bool all = true, any = false;
    const int here = at[a];
    for (int i = 0; i < n; ++i) {
      at[a] = is_erosion ? here + i : here - i;
      const bool value = grid.has_cell(at) && mask[grid.cell(at)] != 0;
      all = all && value;
      any = any || value;
    }
    result[cell] = is_erosion ? all : any;
  }
  return result;
}

} // namespace

double World::thin_part(int object) const {
  const Specimen& body = scene().objects[object].scene.specimen;
  const Grid& grid = body.grid;
  const double cell = *std::max_element(cell_size().begin(), cell_size().begin() + grid.dimension());
  Index3 n{1, 1, 1};
  for (int a = 0; a < grid.dimension(); ++a)
    n[a] = std::max(1, static_cast<int>(std::ceil(cell / grid.spacing()[a] - tolerance)));
  if (n == Index3{1, 1, 1})
    return 0;
  Mask matter(static_cast<std::size_t>(grid.n_cells()));
  for (std::int64_t i = 0; i < grid.n_cells(); ++i)
    matter[i] = body.is_matter(i);
  Mask opened = matter; // by a box as large as a cell
  for (const bool is_erosion : {true, false})
    for (int axis = 0; axis < grid.dimension(); ++axis)
      opened = along(opened, grid, axis, n[axis], is_erosion);
  const auto all = std::ranges::count(matter, 1), thick = std::ranges::count(opened, 1);
  return static_cast<double>(all - thick) / static_cast<double>(all);
}

} // namespace maille::deform
