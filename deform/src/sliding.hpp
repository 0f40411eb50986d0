#pragma once
/// Scenes whose labels slide on each other, by methods that know nothing of it.

#include "maille/scene/answer.hpp"

#include <functional>
#include <string_view>

namespace maille::deform {

/// By a method that ties nodes of the split scene (see split_borders).
Answer solve_sliding(const Scene& scene, const std::function<Answer(const Scene&)>& solve);

/// By a method whose components do not feel each other: a border that is flat along the grid is whole for the
/// component across it, and cut for the others. Refused where a border is not flat.
/// @param is_of_limits the method takes limits where the scene has none
Answer solve_sliding_by_components(const Scene& scene, std::string_view method, bool is_of_limits,
                                   const std::function<Answer(const Scene&)>& solve);

} // namespace maille::deform
