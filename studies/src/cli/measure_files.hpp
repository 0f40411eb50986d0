#pragma once
/// The files of measures that are lines.

#include "cli/commands.hpp"
#include "results/measure_values.hpp"

namespace maille::studies {

/// SCENE_METHOD_NAME.csv of every measure that is a line and has an answer. @param files  is added to
void write_lines_of_measures(const std::string& method, const std::vector<MeasureRow>& rows,
                             const ResultsFolder& folder, std::vector<std::filesystem::path>& files);

} // namespace maille::studies
