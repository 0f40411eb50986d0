#pragma once
/// The legal state nearest to any state.

#include "lattice/body.hpp"
#include "maille/scene/answer.hpp"

namespace maille::deform {

/// Projects: changes `state` to the feasible state that is nearest to it in the largest change of any
/// component of any node. A feasible state stays as it is, within rounding, and to the bit if its numbers are
/// dyadic. Nothing is held: holds and handles move as far as any other node.
///
/// Homogeneous boxes by scans; small bodies of any other kind by shortest paths; others by the wavefront.
///
/// @param state finite; of the scene's grid; zero where there is no matter, also afterwards
/// @return      the largest change [m]; by the wavefront, beyond its quanta (see TiledBody)
/// Cost         scans: memory passed through twice per side and component, and as much scratch as one
///              component; shortest paths: two searches per component; wavefront: O(nodes)
/// Repeatable   same bits for any number of threads and any vectors
/// Source       docs/theory.md, Theorem 5
/// Checked by   tests/deform/feasible/repair_test.cpp, wavefront_repair_test.cpp
double repair(const Scene& scene, const LinkLimits& limits, Displacement& state, int threads = 1);

/// The same for a body's own numbers. Boxes in float32 and in place; others by way of float64.
double repair(Body& body, const LinkLimits& limits, int threads = 1);

} // namespace maille::deform
