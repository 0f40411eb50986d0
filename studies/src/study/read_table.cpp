/// Tables of studies from text, and from files.

#include "study/plan/study_table.hpp"

#include "maille/materials/json.hpp"
#include "study/table_files.hpp"

#include <algorithm>

namespace maille::studies {

namespace {

namespace fs = std::filesystem;

constexpr std::int64_t largest_table = std::int64_t{1} << 32; // a million cases by four methods

} // namespace

StudyTable parse_study_table(std::string_view text, const fs::path& file) {
  StudyTable table;
  std::vector<Fault> faults;
  int line = 0;
  for (std::size_t start = 0; start < text.size() && faults.size() < most_faults;) {
    const std::size_t end = std::min(text.find('\n', start), text.size());
    const bool is_last = end + 1 >= text.size();
    std::vector<Fault> of_line;
    ++line;
    StudyRow row;
    try {
      row = columns_of_study().read_json(parse_json(text.substr(start, end - start), file, line),
                                         file.string(), line, of_line);
    } catch (const InputError& error) {
      of_line = error.faults();
    }
    table.is_torn = is_last && (end == text.size() || !of_line.empty());
    if (of_line.empty() && !table.is_torn)
      table.rows.push_back(std::move(row));
    else if (!table.is_torn)
      faults.insert(faults.end(), of_line.begin(), of_line.end());
    start = end + 1;
  }
  if (!faults.empty())
    throw InputError(std::move(faults));
  return table;
}

StudyTable read_study_table(const fs::path& file) {
  if (file.extension() == ".csv")
    throw InputError(
        {{file.string(), 0, "", "a table of JSON lines (*.jsonl)", "its copy for other programs"}});
  return parse_study_table(read_own_text_file(file, "a table of a study", largest_table), file);
}

} // namespace maille::studies
