#pragma once
/// What files and pictures show of a body, in which order. No VTK here: numbers only.

#include "maille/scene/scene.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace maille::studies {

/// Which nodes and cells of the grid are in a VTK data set, in the data set's order.
struct BodyNumbering {
  std::vector<std::int64_t> nodes;
  std::vector<std::int64_t> cells;
};

/// Layers of cells across z.
struct Layers {
  int first = 0, end = 0;
};

/// Every node and cell of the grid.
BodyNumbering whole_grid(const Grid& grid);
/// The cells of matter of some layers and their corners, both in the grid's order and by its numbers.
BodyNumbering numbering_of(const Specimen& specimen, const Layers& layers);
/// The same of all layers.
inline BodyNumbering matter_only(const Specimen& specimen) {
  return numbering_of(specimen, {0, specimen.grid.cells()[2]});
}

/// The inverse of to_world: a vector of the world, in the object's frame.
Vec3 to_object(const Placement& placement, const Vec3& vector);

/// A symmetric tensor of the object's frame, XX YY ZZ XY YZ XZ, in the world's.
std::array<double, 6> tensor_to_world(const Placement& placement, const std::array<double, 6>& tensor);

/// @brief The fibres of the cells of matter, each with the sign that agrees with its neighbours.
///
/// Measured directions (from diffusion) have signs by chance, at which arrows and streamlines break. Signs go
/// from cell to cell across faces, through the pair that is most nearly parallel first, so that they agree
/// wherever neighbours do and do not depend on the order of the cells. Each connected part then points along
/// the positive side of the axis that its sum is longest along. One direction for the whole body stays as the
/// scene has it.
///
/// @param placement  in whose world the parts point
/// @return by cell of the grid, object's frame; zero where there is no matter
/// Cost  O(cells log cells)
std::vector<Vec3> with_one_sign(const Specimen& specimen, const Placement& placement);

} // namespace maille::studies
