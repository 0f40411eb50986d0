#pragma once
/// How much slack taut links get.

#include "maille/scene/link_limits.hpp"

namespace maille {

/// The largest |difference of prescribed values| / shortest path, over all pairs of prescribed nodes that are
/// joined: the scale at which the scene's moves just use the slack up. 0 where no joined pair differs.
///
/// Newton's method for largest ratios: at a trial scale one search from all nodes at once finds the pair that
/// is farthest from joined, whose ratio (the best of that node's) is the next scale, until no pair is apart.
/// Scales only grow; two to six pairs of searches, whereas a search from every value that is prescribed takes
/// thousands where a handle turns.
///
/// Source  Dinkelbach, On nonlinear fractional programming (1967), Management Science 13, 492
/// @param unit  links whose slack, alike in both directions, is that of a scale of 1
double taut_scale(const Scene& scene, const LinkLimits& unit);

} // namespace maille
