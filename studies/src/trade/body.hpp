#pragma once
/// Whether a body is still itself on a coarser lattice, and whether a scene is of the kinds that the stored
/// trades are of.

#include "maille/scene/scene.hpp"

#include <string>
#include <vector>

namespace maille::studies {

/// How thick the body is in cells: of generated shapes the fewest cells along an axis; of images, of that
/// material where it is least, the median over its cells of the shortest row of equal cells that a cell lies
/// in.
double thickness_in_cells(const Scene& scene);

/// Why a lattice no longer holds the body of `scene`: materials that have vanished or changed their volume by
/// a quarter, and what is less than two cells thick there. Empty where it holds it.
/// @param thickness of `scene`, in its cells @param halvings see Lattices::at
std::string what_is_lost(const Scene& scene, double thickness, const Scene& on_lattice, int halvings);

/// In what the scene is unlike those of studies/trade/table.csv: loads, images, Poisson's ratio, fibres,
/// slenderness, flat cells. Empty where it is like them.
std::vector<std::string> how_unlike_the_table(const Scene& scene);

} // namespace maille::studies
