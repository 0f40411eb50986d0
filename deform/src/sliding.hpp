#pragma once
/// Scenes whose labels slide on each other, by methods that know nothing of it.

#include "maille/scene/answer.hpp"

#include <functional>
#include <optional>
#include <string>

namespace maille::deform {

/// By a method that ties nodes of the split scene (see split_borders).
/// @param is_of_limits the method takes limits where the scene has none
Answer solve_sliding(const Scene& scene, bool is_of_limits, const std::function<Answer(const Scene&)>& solve);

/// By a method whose components do not feel each other: a border that is flat along the grid is whole for the
/// component across it, and cut for the others.
/// @param obstacle  why there is no answer: a border that is not flat, or a third label that joins two sides
/// @pre no friction
std::optional<Answer> solve_sliding_by_components(const Scene& scene, bool is_of_limits,
                                                  const std::function<Answer(const Scene&)>& solve,
                                                  std::string& obstacle);

/// Why methods that know no Poisson effect cannot take a scene's friction; empty where it has none.
std::string friction_that_asks_for_forces(const Scene& scene);

} // namespace maille::deform
