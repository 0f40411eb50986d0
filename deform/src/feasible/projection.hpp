#pragma once
/// From any state to a feasible one that keeps holds and handles.

#include "feasible/bounds/clipping.hpp"
#include "lattice/body.hpp"
#include "lattice/field_memory.hpp"
#include "maille/scene/answer.hpp"

#include <cstdint>

namespace maille::deform {

/// What the limits permit of the scene's requests, by the cheapest way. See clip().
Clipping clip_fast(const Scene& scene, const LinkLimits& limits, int threads);

/// Changes `state` to a feasible one in which the prescribed components have their values: the nearest
/// feasible state (projection), then the least change that brings the prescribed nodes to their values (clamp
/// between the bounds that they span).
/// @param prescribed clipped
/// @return bytes held meanwhile
std::int64_t make_feasible(const Scene& scene, const LinkLimits& limits,
                           const std::vector<Prescribed>& prescribed, Displacement& state, int threads);

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
/// Checked by   tests/deform/feasible/projection_test.cpp, wavefront_projection_test.cpp
double project(const Scene& scene, const LinkLimits& limits, Displacement& state, int threads = 1);

/// The same for a body's own numbers. Boxes in float32 and in place; others by way of float64.
double project(Body& body, const LinkLimits& limits, int threads = 1);

/// One side of a projection: the least feasible field above what the field holds, or the greatest below it.
template<class T>
struct Closure {
  Field<T> field;
  int nodes[3] = {};
  bool is_least_above = true;
  double ahead[3] = {}, behind[3] = {}; ///< Slopes of Side::least where it is least above, else of greatest
};

/// Scans one slab along x and y, forward and backward. Slabs are independent of each other.
void close_slab(const Closure<float>& closure, int z);
void close_slab(const Closure<double>& closure, int z);

/// Scans the rows y of all slabs along z, forward and backward. Rows are independent of each other.
void close_along_z(const Closure<float>& closure, int y);
void close_along_z(const Closure<double>& closure, int y);

/// The rows y of all slabs: below = mean of above and below. @return the largest difference of the two
double take_mean(const Field<float>& below, const Field<float>& above, const int* nodes, int y);
double take_mean(const Field<double>& below, const Field<double>& above, const int* nodes, int y);

} // namespace maille::deform
