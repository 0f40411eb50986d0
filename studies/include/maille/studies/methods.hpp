#pragma once
/// All ways to answer a scene, by name, from both sides.

#include "maille/scene/answer.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace maille::studies {

/// Every method's name: those of deform first, then fem_q1 and fem_q2, then calculix, which
/// needs that program to be installed.
std::vector<std::string> all_methods();
bool is_method(std::string_view name);

/// Answers `scene` by the method called `name`.
/// @pre is_method(name)
Answer answer_by(const Scene& scene, std::string_view name, const Control& control);

/// The reference that `methods` imply: fem_q2 if they name it, else fem_q1.
std::string default_reference(const std::vector<std::string>& methods);

} // namespace maille::studies
