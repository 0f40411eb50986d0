#include "elastic/model/thin_cells.hpp"

#include <Eigen/LU>

#include <array>

namespace maille::deform {

std::uint8_t thin_axes(const Specimen& body, const Index3& cell) {
  const Grid& grid = body.grid;
  if (grid.dimension() != 3)
    return 0;
  const std::int64_t number = grid.cell(cell);
  std::int64_t to_next = 1; // along the axis
  std::uint8_t axes = 0;
  for (std::size_t a = 0; a < 3; to_next *= grid.cells()[a++]) {
    int in_a_row = 1;
    for (const int direction : {-1, 1})
      for (int at = cell[a] + direction; in_a_row <= most_cells_of_thin; ++in_a_row, at += direction)
        if (at < 0 || at >= grid.cells()[a] || !body.is_matter(number + to_next * (at - cell[a])))
          break;
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
