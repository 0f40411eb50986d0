#pragma once
/// Files that commands write in addition to their results: lines of measures, films.

#include "cli/commands.hpp"
#include "compare/comparison.hpp"
#include "results/measure_values.hpp"

namespace maille::studies {

/// Writes SCENE_METHOD_NAME.csv for every line measure with an answer. @param files  receives the new files
void write_lines_of_measures(const std::string& method, const std::vector<MeasureRow>& rows,
                             const ResultsFolder& folder, std::vector<std::filesystem::path>& files);

/// @brief Films the body from rest through all solved steps: one view and one colour scale (length of the
///        displacement) for all steps, displacements at true scale.
/// @param steps  of one method, on the same grid, each with its answer
/// @param mp4    written atomically
/// @return nothing, or the reason of a failure: no ffmpeg, no OpenGL, no answer
/// Cost  one picture of 1000 pixels per step, in a temporary folder
[[nodiscard]] std::optional<std::string> film_steps(const Scene& scene, const std::string& method,
                                                    const std::vector<Comparison>& steps,
                                                    const std::filesystem::path& mp4);

} // namespace maille::studies
