#pragma once
/// What an answer by `limits` takes: by which algorithm, and which arrays.
///
/// The plan is made by the code that the answer then runs, so `check` and `explain` print what happens. All
/// algorithms give the same displacement; the choice is one of time and memory.

#include "maille/scene/answer.hpp"

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace maille::deform {

/// One array, or several alike.
struct ArrayBytes {
  std::string name;
  std::int64_t bytes = 0;
  std::string why; ///< what makes it necessary, and how large it is
};
using Footprint = std::vector<ArrayBytes>;

/// The sum over all arrays [bytes].
inline std::int64_t bytes_of(const Footprint& footprint) {
  std::int64_t sum = 0;
  for (const ArrayBytes& array : footprint)
    sum += array.bytes;
  return sum;
}

/// The exact ways to propagate one component, the cheapest first. They give the same answer: bit for bit if
/// the numbers are dyadic, within rounding otherwise (of the wavefront's quanta, see TiledBody).
enum class Algorithm {
  rest,            ///< nothing moves
  closed_form,     ///< homogeneous; every handle reaches every node monotonely; handle after handle
  separable_scans, ///< homogeneous box; any number of handles at once
  wavefront,       ///< any body, by tiles in whole quanta
  dijkstra,        ///< any body, node by node in float64: for those so small that no tiles are worth making
};
std::string_view to_string(Algorithm algorithm);

/// How a scene would be answered.
struct Plan {
  std::array<Algorithm, 3> of_component{}; ///< of the scene
  std::string algorithm;                   ///< in words, as in Answer::algorithm
  Footprint arrays;                        ///< that will be held at the peak
  /// Their sum, as in Answer::bytes; of the wavefront, which makes the links of a tile when it first visits
  /// it, and of Dijkstra, whose queue is as long as its front, no more than these.
  std::int64_t bytes = 0;
};

/// Names the way without going it. Cost: O(nodes) for a body that does not fill its grid, else O(handles).
/// @param limits of `scene`; @param threads as in Control
Plan plan_limits(const Scene& scene, const LinkLimits& limits, int threads = 1);

/// Moves the prescribed components of a resting body and lets every other one follow as little as its links'
/// limits allow: the answer of solve_limits (see there), sooner. The numbers are float64 here, as the answer
/// is; a Drag works in float32.
///
/// Before anything moves, requests are cut back to what holds and limits permit: see clip().
///
/// @return status done or clamped; refused for loads and for moves that are not finite; interrupted or
/// budget_reached with a feasible state. `iterations` counts nodes visited, one per component and pass
/// Cost        closed form: memory written once per handle, only where nodes move. Scans: memory passed
///             twice, whatever the number of handles. Wavefront: one to six visits of what moves. Dijkstra:
///             O(links log nodes) per component
/// Repeatable  same bits in any order of the prescribed values, for any number of threads, on any machine
/// Source      docs/theory.md, section 1
/// Checked by  tests/deform/feasible/drag_test.cpp
Answer solve_by_cheapest_way(const Scene& scene, const Control& control = {});

} // namespace maille::deform
