#pragma once
/// Errors of force, energy, strain and stress of an answer, from more accurate states.

#include "maille/mechanics/recovery.hpp"
#include "maille/scene/answer.hpp"

namespace maille::deform {

/// `answer` in the body's frame: its forces, and its displacement `u`, turned. @pre frame is
/// object_frame(scene)
Answer mechanics_in_object(const Scene& scene, const Frame& frame, const Answer& answer,
                           const Displacement& u);

/// Error of the model, answer - elastic, plus error of the lattice, elastic - finer, times an error over the
/// part that half the spacing removes. Relative to `finer`.
/// @param elastic a state of full elasticity on the lattice of `scene`; missing reactions are computed
/// @param is_along_lines forces act along lines or at points, where convergence is slower
/// Cost  O(cells); memory: two displacements and the operator of `coupled`
MechanicsErrors mechanics_by_finer(const Scene& scene, const Answer& answer, const Answer& elastic,
                                   const Answer& finer, bool is_along_lines);

/// Error of the model in force and energy; error of strain and stress from the estimated error of
/// displacement. Relative to `elastic`.
MechanicsErrors mechanics_of_model(const Scene& scene, const Answer& answer, const Answer& elastic,
                                   const Displacement& error);

} // namespace maille::deform
