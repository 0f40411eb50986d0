#pragma once
/// `coupled` where the scene asks for finite strain.

#include "maille/scene/answer.hpp"

namespace maille::deform {

/// @pre 2D or 3D, and no rigid motion is left. Where the scene's limits bind (see Scene::limits_bind_coupled)
/// and the elastic answer breaks them, the answer is the least energy within them near it, each link in the
/// mean frame of the cells around, and feasible whenever it ends; where no feasible state is found, moves and
/// loads are cut back by bisection (status clamped), and the message says to what share.
Answer solve_coupled_finite(const Scene& scene, const Control& control);

} // namespace maille::deform
