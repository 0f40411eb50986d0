#pragma once
/// `literal`: Gibson's chain mail of 1997, first moved, first processed. Kept as the oracle of `limits`.

#include "maille/scene/answer.hpp"

namespace maille::deform {

/// Moves the prescribed components of a resting body and lets neighbours follow along candidate lists, one
/// per direction, worked off in turn: a node moved by a neighbour along x offers the next along x and both
/// neighbours along y and z, one moved along y the next along y and both along z, one moved along z the next
/// along z. A candidate is moved just as far as the link to the node that offered it asks. Holds never move.
///
/// On a box of one material with one handle it is `limits`, to the bit where sums are exact. **Wrong
/// elsewhere**: it follows one path only and leaves links outside their limits (docs/theory.md, section 1).
/// Departure: a prescribed component stays where it was put; in 1997 a second handle carries the first along.
///
/// @return status done, with a message that counts the links left outside their limits and says the worst, if
///         any; refused for loads and moves that are not finite; interrupted or budget_reached. `iterations`
///         counts the candidates visited
/// Repeatable  same input, same bits; handles are taken in the order of their node numbers
/// Source      Gibson 1997, 3D ChainMail, with the lists in the order -x +x -y +y -z +z
/// Checked by  tests/deform/feasible/limits_test.cpp
Answer solve_literal(const Scene& scene, const Control& control = {});

/// Held at the peak, at most [bytes].
std::int64_t bytes_for_literal(const Scene& scene);

} // namespace maille::deform
