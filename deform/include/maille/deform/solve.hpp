#pragma once
/// The one-call door of the product: Scene in, Answer out.

#include "maille/scene/answer.hpp"

#include <string_view>
#include <vector>

namespace maille::deform {

/// Names of the methods here: limits, dijkstra (its oracle), literal, sweep, relaxed, coupled.
const std::vector<std::string_view>& methods();

/// Answers `scene` by `method`, within the object's frame (see object_frame): where the moves turn a body
/// that nothing holds, the method works in the turned frame, and its answer is turned with it.
/// @return status refused where the method cannot carry the scene (loads; unknown method), or where it would
///         take more memory than there is, or than Control::bytes_budget: before it takes any
/// Repeatable: same input, same bits, any number of threads.
Answer solve(const Scene& scene, std::string_view method, const Control& control = {});
/// The same by enumeration: a slip does not compile. Of methods that are not here (finite elements) refused.
Answer solve(const Scene& scene, Method method, const Control& control = {});

/// The elastic energy of every cell of the grid [J], by what the method minimises, so that they add up to
/// Answer::strain_energy (of `relaxed`, whose weights are float32, to 1e-6); zero without matter. Of other
/// methods Answer::cell_energy.
/// @param answer  of solve(scene, ...)
/// Cost  O(cells); no method computes it by itself
std::vector<double> cell_energies(const Scene& scene, const Answer& answer);

/// The memory that a method is expected to hold at its peak, at most [bytes]; 0 for a method that is not
/// known.
std::int64_t bytes_needed(const Scene& scene, std::string_view method);
std::int64_t bytes_needed(const Scene& scene, Method method);

} // namespace maille::deform
