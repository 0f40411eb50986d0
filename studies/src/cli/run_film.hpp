#pragma once
/// A film of the steps of a run. Weak: in the program maille-studies alone.

#include "compare/comparison.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace maille::studies {

/// @brief Films the body from rest through every step that has an answer: one view and one scale of colours
///        (length of the displacement) for all, displacements drawn as they are.
///
/// @param steps  of one method, equal in size, each with its answer
/// @param mp4    appears whole or not at all
/// @return nothing, or why there is no film: no ffmpeg, no OpenGL, no answer
/// Cost  a picture of 1000 pixels a step, in a temporary folder until the film is made
[[nodiscard, gnu::weak]] std::optional<std::string> film_steps(const Scene& scene, const std::string& method,
                                                               const std::vector<Comparison>& steps,
                                                               const std::filesystem::path& mp4);

} // namespace maille::studies
