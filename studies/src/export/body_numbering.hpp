#pragma once
/// Order of nodes and cells in files and pictures of a body. Numbers only, no VTK.

#include "maille/scene/scene.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace maille::studies {

/// Grid nodes and cells of a VTK data set, in its order.
struct BodyNumbering {
  std::vector<std::int64_t> nodes;
  std::vector<std::int64_t> cells;
};

/// Layers of cells across z.
struct Layers {
  int first = 0, end = 0;
};

/// Numbering with all nodes and cells of the grid.
BodyNumbering whole_grid(const Grid& grid);
/// The cells of matter of some layers and their corners, both in the grid's order and by its numbers.
BodyNumbering numbering_of(const Specimen& specimen, const Layers& layers);
/// The same of all layers.
inline BodyNumbering matter_only(const Specimen& specimen) {
  return numbering_of(specimen, {0, specimen.grid.cells()[2]});
}

/// Inverse of to_world: rotates a world vector into the object's frame.
Vec3 to_object(const Placement& placement, const Vec3& vector);

/// Rotates a symmetric tensor XX YY ZZ XY YZ XZ from the object's frame to the world's.
std::array<double, 6> tensor_to_world(const Placement& placement, const std::array<double, 6>& tensor);

/// @brief Fibres of the cells, with signs that agree between neighbours.
///
/// Measured directions (from diffusion) have random signs, which break arrows and streamlines. Signs
/// propagate from cell to cell across faces, through the most nearly parallel pair first, so that they agree
/// wherever neighbours do and do not depend on the order of the cells. Each connected part then points along
/// the positive side of the axis that its sum is longest along. A single direction for the whole body does
/// not change.
///
/// @param placement  its world defines the positive directions
/// @return by grid cell, object's frame; zero outside the body
/// Cost  O(cells log cells)
std::vector<Vec3> with_one_sign(const Specimen& specimen, const Placement& placement);

} // namespace maille::studies
