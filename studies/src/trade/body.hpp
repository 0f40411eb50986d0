#pragma once
/// Checks whether a coarser lattice still represents a body, and whether a scene resembles the scenes of the
/// stored trades.

#include "maille/scene/scene.hpp"

#include <string>
#include <vector>

namespace maille::studies {

/// Thickness of the body in cells. Generated shapes: the fewest cells along an axis. Images: the smallest
/// value over the materials of the median, over their cells, of the shortest row of equal cells through a
/// cell.
double thickness_in_cells(const Scene& scene);

/// Reason that a lattice no longer represents the body of `scene`: materials that vanished or changed their
/// volume by a quarter, and parts less than two cells thick there. Empty if it does.
/// @param thickness of `scene`, in its cells @param halvings see Lattices::at
std::string what_is_lost(const Scene& scene, double thickness, const Scene& on_lattice, int halvings);

/// Properties in which the scene differs from those of studies/trade/table.csv: loads, images, Poisson's
/// ratio, fibres, slenderness, flat cells. Empty if there are none.
std::vector<std::string> how_unlike_the_table(const Scene& scene);

} // namespace maille::studies
