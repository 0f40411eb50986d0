#pragma once
/// Plan of an answer by `limits`: its algorithm and arrays.
///
/// The answer runs the same code that makes the plan, so that `check` and `explain` print what happens. All
/// algorithms give the same displacement; they differ in time and memory.

#include "maille/scene/answer.hpp"

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace maille::deform {

/// One array, or several equal ones.
struct ArrayBytes {
  std::string name;
  std::int64_t bytes = 0;
  std::string why; ///< its purpose and the origin of its size
};
using Footprint = std::vector<ArrayBytes>;

/// The sum over all arrays [bytes].
inline std::int64_t bytes_of(const Footprint& footprint) {
  std::int64_t sum = 0;
  for (const ArrayBytes& array : footprint)
    sum += array.bytes;
  return sum;
}

/// Exact algorithms to propagate one component, the cheapest first. They give the same answer: bit-identical
/// for dyadic numbers, else within rounding (of the wavefront's quanta, see TiledBody).
enum class Algorithm {
  rest,            ///< nothing moves
  closed_form,     ///< homogeneous, monotone paths from every handle to every node; handle by handle
  separable_scans, ///< homogeneous box; any number of handles at once
  wavefront,       ///< any body, by tiles in whole quanta
  dijkstra,        ///< any body, node by node in float64: for bodies too small for tiles
};
std::string_view to_string(Algorithm algorithm);

/// Plan for a scene.
struct Plan {
  std::array<Algorithm, 3> of_component{}; ///< of the scene
  std::string algorithm;                   ///< in words, as in Answer::algorithm
  Footprint arrays;                        ///< at the peak
  /// Their sum, as in Answer::bytes; an upper bound for the wavefront, which makes the links of a tile at its
  /// first visit, and for Dijkstra, whose queue is as long as its front.
  std::int64_t bytes = 0;
};

/// Selects the algorithm without running it. Cost: O(nodes) for a body that does not fill its grid, else
/// O(handles).
/// @param limits of `scene`; @param threads as in Control
Plan plan_limits(const Scene& scene, const LinkLimits& limits, int threads = 1);

/// Moves the prescribed components of a body at rest; the others follow as little as the limits of their
/// links allow. The answer is that of solve_limits() (see there), but faster, in float64; a Drag uses
/// float32.
///
/// Requests are first clipped to holds and limits: see clip().
///
/// @return status done or clamped; refused for loads and for moves that are not finite; interrupted or
///         budget_reached with a feasible state. `iterations` counts visited nodes, per component and pass
/// Cost        closed form: memory written once per handle, only where nodes move. Scans: two passes over
///             memory for any number of handles. Wavefront: one to six visits of moved nodes. Dijkstra:
///             O(links log nodes) per component
/// Repeatable  same bits in any order of the prescribed values, for any number of threads, on any machine
/// Source      docs/theory.md, section 1
/// Checked by  tests/deform/feasible/drag_test.cpp
Answer solve_by_cheapest_way(const Scene& scene, const Control& control = {});

} // namespace maille::deform
