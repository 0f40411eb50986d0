#pragma once
/// The same scene on a lattice of half the spacing.

#include "maille/scene/answer.hpp"

namespace maille {

/// A copy of `scene` with every cell cut into 2^dimension: same body, same loads. A new node is prescribed if
/// all nodes that it lies between (of an edge, face or cell) are, with their mean value, as in degree 2 of
/// fem_ref, so the two lattices differ only in the mesh. Taut limits and left-out pieces stay those of
/// `scene`.
/// @pre 2^dimension times the cells can be counted by an int along every axis; @throws std::length_error
///      otherwise
/// Cost   O(cells of the result)
Scene refined(const Scene& scene);

/// The displacement of refined(scene) at the nodes of `scene`.
Displacement at_coarse_nodes(const Scene& scene, const Scene& fine, const Displacement& displacement);
/// The same for a whole answer. Reactions are shared equally by the nodes that their node lies between, which
/// keeps their sum and moment; energies and mean strains, if any, go to the cells that theirs are cut from.
/// Nodal strains and stresses are omitted.
void bring_to_coarse(const Scene& scene, const Scene& fine, Answer& answer);

} // namespace maille
