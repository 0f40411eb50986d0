#pragma once
/// The same question on a lattice of half the spacing.

#include "maille/scene/answer.hpp"

namespace maille {

/// A copy of `scene` whose every cell is cut into 2^dimension: same body, same loads. A new node is
/// prescribed where the nodes that it lies between (of an edge, face or cell) all are, at the mean of their
/// values, as degree 2 of fem_ref has it; so what the two lattices ask differs by nothing but the mesh. Taut
/// limits and pieces that were left out stay those of `scene`.
/// @pre 2^dimension times the cells can be counted by an int along every axis; @throws std::length_error
///      otherwise
/// Cost   O(cells of the result)
Scene refined(const Scene& scene);

/// The part of an answer to refined(scene) that stands at the nodes of `scene`.
Displacement at_coarse_nodes(const Scene& scene, const Scene& fine, const Displacement& displacement);
/// The same of a whole answer: reactions go in equal parts to the nodes that theirs lie between, which keeps
/// their sum and their moment, and energies and
/// mean strains, where it keeps some, to the cells that theirs are cut from. Nodal strains and stresses
/// are left out.
void bring_to_coarse(const Scene& scene, const Scene& fine, Answer& answer);

} // namespace maille
