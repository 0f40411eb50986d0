#pragma once
/// How far force, energy, strain and stress of an answer are from elasticity, from states that are nearer.

#include "maille/mechanics/recovery.hpp"
#include "maille/scene/answer.hpp"

namespace maille::deform {

/// What `answer` says within the body's frame: forces there, and `u`, its displacement there.
/// @pre frame is object_frame(scene)
Answer mechanics_in_object(const Scene& scene, const Frame& frame, const Answer& answer,
                           const Displacement& u);

/// The model's part, answer - elastic, and the lattice's: elastic - finer, times an error over its part that
/// half the spacing takes away. Relative to `finer`.
/// @param elastic a state of full elasticity on the lattice of `scene`; its reactions are found where it has
///        none
/// @param finer that of half the spacing, brought to the lattice of `scene`, with reactions
/// @param is_along_lines forces act along lines or at points, where less goes with every halving
/// Cost  O(cells); memory: two displacements and the operator of `coupled`
MechanicsErrors mechanics_by_finer(const Scene& scene, const Answer& answer, const Answer& elastic,
                                   const Answer& finer, bool is_along_lines);

/// The model's part of force and energy alone; strain and stress of the displacement that is estimated to be
/// wrong. Relative to `elastic`.
MechanicsErrors mechanics_of_model(const Scene& scene, const Answer& answer, const Answer& elastic,
                                   const Displacement& error);

} // namespace maille::deform
