#pragma once
/// The one scale at which taut links just let a scene's moves happen.

#include "maille/scene/link_limits.hpp"

namespace maille {

/// The largest |difference of prescribed values| / shortest path, over all pairs of prescribed nodes that are
/// joined: the scale at which the scene's moves just use the slack up. 0 where no joined pair differs.
///
/// Where the values of a component are two, as of a body that is held and moved, one search from all nodes
/// with the lower one says it. Elsewhere Newton's method for largest ratios: at a trial scale one search from
/// all nodes at once finds the pair that is farthest from joined, whose ratio (the best of that node's) is
/// the next scale, until no pair is apart. Scales only grow; two to six pairs of searches. On a box of one
/// matter a search is two scans along every axis, elsewhere Dijkstra's.
///
/// @param unit  links whose slack, alike in both directions, is that of a scale of 1
/// Cost    of a search on a box some 6 ns a node, elsewhere see shortest_paths()
/// Source  Dinkelbach, On nonlinear fractional programming (1967), Management Science 13, 492
/// Checked by  tests/scene/link_limits_test.cpp
double taut_scale(const Scene& scene, const LinkLimits& unit);

} // namespace maille
