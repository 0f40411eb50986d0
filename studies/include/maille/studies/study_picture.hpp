#pragma once
/// The picture of a study.

#include "maille/studies/study_table.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace maille::studies {

/// Draws the relative L2 error of every method over every parameter that has several values: a plot a scene
/// and parameter, all of one scale of errors. At every value stands the median over the cases that share it;
/// what is below 0.001 % stands at the bottom.
/// @param title above all plots @param file *.svg, else PNG; replaced at once
/// @return why there is no picture: no errors over several values, or no gnuplot
/// @throws std::runtime_error where gnuplot fails; std::filesystem::filesystem_error
std::optional<std::string> draw_study(const std::vector<StudyRow>& rows, const std::string& title,
                                      const std::filesystem::path& file);

} // namespace maille::studies
