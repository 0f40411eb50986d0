#pragma once
/// The legal state nearest to any state.

#include "maille/deform/lattice/body.hpp"
#include "maille/scene/answer.hpp"

namespace maille::deform {

/// Changes `state` to the legal state that is nearest to it in the largest change of any component of any
/// node; a legal state stays as it is, within rounding, and to the bit if its numbers are dyadic.
///
/// majorant_j = max over i of x_i - d(j, i) is the least legal state above x, minorant_j = min over i of x_i +
/// d(i, j) the greatest below it, and their mean is legal because legal states are convex. No legal state is
/// nearer: if two nodes contradict their path by w, one of them must move by w / 2, and the mean moves no node
/// by more. Nothing is held: holds and handles move as far as any other node.
///
/// Homogeneous boxes by scans, forward and backward along each axis; small bodies of any other kind by
/// shortest paths; others by the wavefront, in whole quanta (see TiledBody).
///
/// @param state finite; of the scene's grid; zero where there is no matter, also afterwards
/// @return      the largest change [m]; by the wavefront, beyond its quanta
/// Cost         scans: memory passed through twice per side and component, and as much scratch as one component;
///              shortest paths: two searches per component; wavefront: O(nodes)
/// Repeatable   same bits for any number of threads and any vectors
/// Source       docs/theory.md, Theorem 5
/// Checked by   tests/deform/propagate/repair_test.cpp
double repair(const Scene& scene, const LinkLimits& limits, Displacement& state, int threads = 1);

/// The same for a body's own numbers. Boxes in float32 and in place; others by way of float64.
double repair(Body& body, const LinkLimits& limits, int threads = 1);

} // namespace maille::deform
