#pragma once
/// Cheap answers that speak for another quantity than the displacement.

#include "trade/probes.hpp"

namespace maille::studies {

/// Answers by `coupled` on three lattices that hold the body, each of half the spacing of the one before: the
/// coarsest that approach each other, of four times to a quarter of the scene's spacing, of which the last
/// three hold the very same body. Numbers have to move on in one direction, and an order of more than 2 is
/// not believed. `growth` and `distance` are those of the quantity, nothing is said about other methods.
/// Cost  about twice `coupled` on the finest of them, of a million cells at most
/// @pre !quantity.is_displacement()
Probes probe_quantity(Lattices& lattices, const Quantity& quantity, const Control& control);

} // namespace maille::studies
