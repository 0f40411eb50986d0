#pragma once
/// `coupled` for scenes with `strain = "finite"`.

#include "elastic/krylov/kept_body.hpp"

namespace maille::deform {

/// @pre 2D or 3D, and no rigid motion is left. Where the scene's limits bind (see Scene::limits_bind_coupled)
/// and the elastic answer breaks them, the answer is the least energy within them near it, each link in the
/// mean frame of the cells around, and feasible whenever it ends; where no feasible state is found, moves and
/// loads are cut back by bisection (status clamped), and the message says to what share.
/// @param kept of the scene's body: the answer begins where earlier ones point to (see EarlierAnswers), with
///        the preconditioner of the last; within the scene's tolerance of the answer from rest, where that is
///        of the same branch. Limits begin at the elastic answer. Null: from rest
Answer solve_coupled_finite(const Scene& scene, const Control& control, KeptBody* kept = nullptr);

} // namespace maille::deform
