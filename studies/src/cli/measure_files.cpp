#include "cli/measure_files.hpp"

#include "export/whole_file.hpp"

#include <fmt/format.h>

namespace maille::studies {

void write_lines_of_measures(const std::string& method, const std::vector<MeasureRow>& rows,
                             const ResultsFolder& folder, std::vector<std::filesystem::path>& files) {
  for (const MeasureRow& row : rows)
    if (!row.value.line.empty()) {
      files.push_back(folder.file(fmt::format("_{}_{}.csv", method, row.value.name)));
      write_whole(files.back(), line_csv(row.value));
    }
}

} // namespace maille::studies
