#pragma once
/// Which cells of a body are part of something thin.

#include "maille/scene/scene.hpp"

#include <cstdint>

namespace maille::deform {

/// Along an axis, so many cells of matter in a row or fewer are thin. 0: none. With 2 they bend as plates
/// do, but then boxes so thin are for masked bodies, whose multigrid does not converge on long rods
/// (docs/developers/relaxation.md).
inline constexpr int most_cells_of_thin = 0;

/// The axes along which a cell of matter is part of a row that is thin: bit a for axis a. In 3D; none
/// elsewhere, where bending is exact as it is.
std::uint8_t thin_axes(const Specimen& body, const Index3& cell);

/// True if some row of a full grid of these cells is thin. @param cells of a 3D grid
inline bool is_thin_box(const Index3& cells) {
  return cells[0] <= most_cells_of_thin || cells[1] <= most_cells_of_thin || cells[2] <= most_cells_of_thin;
}

} // namespace maille::deform
