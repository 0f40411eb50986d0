#pragma once
/// `literal`: Gibson's chain mail of 1997, first moved, first processed. Kept as the oracle of `limits`.

#include "maille/scene/answer.hpp"

namespace maille::deform {

/// Moves the prescribed components of a resting body and lets neighbours follow along candidate lists.
///
/// All moved nodes are put at their targets first; holds never move. Every node that moved offers its
/// neighbours to one list per direction: one moved by a neighbour along x offers the next along x and both
/// neighbours along y and z, one moved along y the next along y and both along z, one moved along z the next
/// along z. Lists are worked off in turn, and a candidate is moved just as far as the link to the node that
/// offered it asks.
///
/// Exact on a box of one material with one handle, where every node has one such path from the handle and it
/// is a shortest one: the answer is then that of `limits` bit for bit, as long as the sums are exact. **Wrong
/// elsewhere**: it follows one path only. Measured on 50^3 boxes (chainmail-literature.md, section 3): a
/// stiff ball in a soft block leaves 2.9 % of the links outside their limits, the worst by 2.45 spacings; 30
/// % random stiff voxels 20.2 %, 5.3 spacings; around a slot 50,000 of 105,000 nodes move that must, 14.5
/// spacings; with two handles one after the other the first is carried 16 spacings away, and the order of the
/// two changes everything.
///
/// Departure from the source: a prescribed component stays where it was put, so that the answer meets the
/// question; in 1997 a second handle carries the first along. What cannot be met shows as broken links.
///
/// @return status done, with a message that counts the links left outside their limits and says the worst, if
///         there are any; refused for loads and moves that are not finite; interrupted or budget_reached.
///         `iterations` counts the candidates visited
/// Cost        O(candidates visited): each node once on a box with one handle
/// Repeatable  same input, same bits; handles are taken in the order of their node numbers
/// Source      Gibson 1997, 3D ChainMail (Proc. Symposium on Interactive 3D Graphics), with the lists in the
///             order -x +x -y +y -z +z
/// Checked by  tests/deform/feasible/literal_test.cpp
Answer solve_literal(const Scene& scene, const Control& control = {});

} // namespace maille::deform
