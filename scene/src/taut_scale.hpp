#pragma once
/// The smallest scale of taut limits at which a scene's moves are feasible.

#include "maille/scene/link_limits.hpp"

namespace maille {

/// The largest |difference of prescribed values| / shortest path, over all connected pairs of prescribed
/// nodes: the scale at which the scene's moves use up the slack exactly. 0 if no connected pair differs.
///
/// If a component has two prescribed values, as for a body that is held and moved, one search from all nodes
/// with the lower value is enough. Otherwise Newton's method for the largest ratio: at a trial scale one
/// search from all nodes at once finds the most violated pair; its ratio (the best for that node) is the next
/// scale, until no pair is violated. Scales only grow; two to six pairs of searches. On a box of one material
/// a search is two scans along every axis, elsewhere Dijkstra's algorithm.
///
/// @param unit  limits at a scale of 1, with equal slack in both directions
/// Cost    of a search: about 6 ns per node on a box, elsewhere see shortest_paths()
/// Source  Dinkelbach, On nonlinear fractional programming (1967), Management Science 13, 492
/// Checked by  tests/scene/link_limits_test.cpp
double taut_scale(const Scene& scene, const LinkLimits& unit);

} // namespace maille
