#pragma once
/// Directions without a sign, given one.

#include "maille/scene/scene.hpp"

#include <vector>

namespace maille::studies {

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
