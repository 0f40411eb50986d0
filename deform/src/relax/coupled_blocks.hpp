#pragma once
/// `coupled` where the scene asks for blocks: see CorotatedRelaxation.

#include "maille/scene/answer.hpp"

namespace maille::deform {

/// @pre 2D or 3D, and no rigid motion is left. Limits are not enforced: where the scene's bind, the message says by how much they are
/// broken, link by link in the mean frame of the cells around.
Answer solve_coupled_in_blocks(const Scene& scene, const Control& control);

} // namespace maille::deform
