#include "body_numbering.hpp"

#include <numeric>

namespace maille::studies {

BodyNumbering whole_grid(const Grid& grid) {
  BodyNumbering numbering;
  numbering.nodes.resize(grid.n_nodes());
  numbering.cells.resize(grid.n_cells());
  std::iota(numbering.nodes.begin(), numbering.nodes.end(), std::int64_t{0});
  std::iota(numbering.cells.begin(), numbering.cells.end(), std::int64_t{0});
  return numbering;
}

BodyNumbering numbering_of(const Specimen& specimen, const Layers& layers) {
  const Grid& grid = specimen.grid;
  BodyNumbering numbering;
  const std::int64_t first_node = grid.node({0, 0, layers.first});
  std::vector<bool> used((layers.end - layers.first + 1) * grid.stride(2));
  for (std::int64_t cell = grid.cell({0, 0, layers.first}); cell < grid.cell({0, 0, layers.end}); ++cell) {
    if (!specimen.is_matter(cell))
      continue;
    numbering.cells.push_back(cell);
    for (int corner = 0; corner < grid.corners_per_cell(); ++corner)
      used[grid.corner(grid.cell_at(cell), corner) - first_node] = true;
  }
  for (std::size_t i = 0; i < used.size(); ++i)
    if (used[i])
      numbering.nodes.push_back(first_node + static_cast<std::int64_t>(i));
  return numbering;
}

Vec3 to_object(const Placement& placement, const Vec3& vector) {
  Vec3 result{}; // directions are orthonormal
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 3; ++column)
      result[column] += placement.direction[row][column] * vector[row];
  return result;
}

std::array<double, 6> tensor_to_world(const Placement& placement, const std::array<double, 6>& tensor) {
  if (placement.direction == Placement{}.direction)
    return tensor;
  const std::array<Vec3, 3> in_object{{{tensor[0], tensor[3], tensor[5]},
                                       {tensor[3], tensor[1], tensor[4]},
                                       {tensor[5], tensor[4], tensor[2]}}};
  std::array<Vec3, 3> half{}; // rotates its rows, then its columns
  for (std::size_t row = 0; row < 3; ++row)
    half[row] = to_world(placement, in_object[row]);
  std::array<Vec3, 3> turned{};
  for (std::size_t column = 0; column < 3; ++column)
    turned[column] = to_world(placement, Vec3{half[0][column], half[1][column], half[2][column]});
  return {turned[0][0], turned[1][1], turned[2][2], turned[0][1], turned[1][2], turned[0][2]};
}

} // namespace maille::studies
