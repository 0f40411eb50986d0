#pragma once
/// The finest level of the componentwise model, from a scene.

#include "elastic/componentwise/componentwise_level.hpp"
#include "elastic/model/cell_moduli.hpp"

namespace maille::deform {

/// Nodes along the level's axes: those of the grid, but that the planes of a 2D body are its rows, so that
/// loops over planes have something to do.
Index3 level_nodes(const Grid& grid);
/// The level's axis for an axis of the grid.
int level_axis(const Grid& grid, int axis);

/// V / h_a^2 per axis of the grid: times a modulus the weight of a link inside matter of one kind [m].
Vec3 weight_per_modulus(const Grid& grid);

/// Weights of one component in units of `unit` [N/m].
LinkWeights link_weights(const Scene& scene, const CellModuli& moduli, int component, double unit);
/// The same as one number per link, on boxes too.
LinkWeights weights_per_link(const Scene& scene, const CellModuli& moduli, int component, double unit);
/// The largest weight that a link inside any cell's matter has [N/m].
double largest_weight(const Scene& scene, const CellModuli& moduli, int component);

/// Which nodes of the body no chain of links joins to a fixed one; empty if none.
std::vector<bool> loose_nodes(const Scene& scene, const std::vector<FixedNode>& fixed);

} // namespace maille::deform
