#include "elastic/model/thin_cells.hpp"

#include <cstdint>

namespace maille::deform {

std::uint8_t thin_axes(const Specimen& body, const Index3& cell) {
  const Grid& grid = body.grid;
  if (grid.dimension() != 3)
    return 0;
  std::uint8_t axes = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    int in_a_row = 1;
    for (const int direction : {-1, 1})
      for (Index3 at = cell; in_a_row <= most_cells_of_thin; ++in_a_row) {
        at[a] += direction;
        if (at[a] < 0 || at[a] >= grid.cells()[a] || !body.is_matter(grid.cell(at)))
          break;
      }
    if (in_a_row <= most_cells_of_thin)
      axes = static_cast<std::uint8_t>(axes | 1u << a);
  }
  return axes;
}

} // namespace maille::deform
