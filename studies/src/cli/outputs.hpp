#pragma once
/// Files that commands write beside their results: lines of measures, films.

#include "cli/commands.hpp"
#include "compare/comparison.hpp"
#include "results/measure_values.hpp"

namespace maille::studies {

/// SCENE_METHOD_NAME.csv of every measure that is a line and has an answer. @param files  is added to
void write_lines_of_measures(const std::string& method, const std::vector<MeasureRow>& rows,
                             const ResultsFolder& folder, std::vector<std::filesystem::path>& files);

/// @brief Films the body from rest through every step that has an answer: one view and one scale of colours
///        (length of the displacement) for all, displacements drawn as they are.
/// @param steps  of one method, equal in size, each with its answer
/// @param mp4    appears whole or not at all
/// @return nothing, or why there is no film: no ffmpeg, no OpenGL, no answer
/// Cost  a picture of 1000 pixels a step, in a temporary folder until the film is made
[[nodiscard]] std::optional<std::string> film_steps(const Scene& scene, const std::string& method,
                                                    const std::vector<Comparison>& steps,
                                                    const std::filesystem::path& mp4);

} // namespace maille::studies
