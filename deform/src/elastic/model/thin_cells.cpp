#include "elastic/model/thin_cells.hpp"

#include <Eigen/LU>

#include <array>
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

Eigen::Matrix3d bending_beyond_links(const Eigen::Matrix<double, 6, 6>& S, int across) {
  const std::array<int, 3> rows{(across + 1) % 3, (across + 2) % 3, 3 + across};
  const Eigen::Matrix3d of_plane = S(rows, rows);
  return Eigen::Matrix3d(of_plane.inverse()) -
         Eigen::Matrix3d(of_plane.diagonal().cwiseInverse().asDiagonal());
}

} // namespace maille::deform
