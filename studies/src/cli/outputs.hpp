#pragma once
/// Files that commands write in addition to their results: lines of measures, films, warped images.

#include "cli/commands.hpp"
#include "compare/comparison.hpp"
#include "export/warp_files.hpp"
#include "picture/comparison_picture.hpp"
#include "results/measure_values.hpp"

namespace maille::studies {

/// Writes SCENE_METHOD_NAME.csv for every line measure with an answer. @param files  receives the new files
void write_lines_of_measures(const std::string& method, const std::vector<MeasureRow>& rows,
                             const ResultsFolder& folder, std::vector<std::filesystem::path>& files);

/// Field of an answer for the colours of a picture: at every node a vector of that size. Strain and stress
/// are means over the cells of a node. @return nothing if the row has no such field
/// @param field  displacement; strain: the principal one of largest size; stress: von Mises'; error: against
///               the reference, else as estimated
std::optional<Displacement> shown_field(const Scene& scene, const Comparison& comparison,
                                        const ComparisonRow& row, const std::string& field);
/// Title, and quantity and unit of the colour bar of such a field.
PictureSettings settings_of_field(const std::string& title, const std::string& field);

/// @brief Films the body from rest through all solved steps: one view and one colour scale for all steps,
///        displacements at true scale.
/// @param steps  of one method, on the same grid, each with its answer
/// @param field  what the colours show, see shown_field
/// @param mp4    written atomically
/// @return nothing, or the reason of a failure: no ffmpeg, no OpenGL, no answer
/// Cost  one picture of 1000 pixels per step, in a temporary folder
[[nodiscard]] std::optional<std::string> film_steps(const Scene& scene, const std::string& method,
                                                    const std::vector<Comparison>& steps,
                                                    const std::string& field,
                                                    const std::filesystem::path& mp4);

/// Warped images in words: one row per label, counts of mapped voxels, and warnings.
std::string in_words(const WarpedFiles& made);
/// The same as JSON; `files` are names without their folder.
nlohmann::ordered_json json(const WarpedFiles& made);

} // namespace maille::studies
