#pragma once
/// `coupled` where the scene asks for blocks: see CorotatedRelaxation.

#include "maille/scene/answer.hpp"

namespace maille::deform {

/// @pre 2D or 3D, and no rigid motion is left. Where the scene's limits bind (see Scene::limits_bind_coupled)
/// the elastic answer is repaired at the end, each link in the mean frame of the cells around; where no such
/// state is found, moves and loads are cut back by bisection (status clamped), and the message says to what
/// share.
Answer solve_coupled_in_blocks(const Scene& scene, const Control& control);

} // namespace maille::deform
