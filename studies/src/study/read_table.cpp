/// Tables of studies from text, and from files.

#include "maille/studies/study_table.hpp"

#include "maille/materials/fault.hpp"
#include "maille/materials/text_file.hpp"

#include <stdexcept>

namespace maille::studies {

namespace {

namespace fs = std::filesystem;

constexpr std::int64_t largest_table = std::int64_t{1} << 32; // a million cases by four methods

} // namespace

std::string_view to_string(Timing timing) {
  switch (timing) {
  case Timing::alone:
    return "alone";
  case Timing::busy:
    return "busy";
  case Timing::side_by_side:
    break;
  }
  return "side_by_side";
}

StudyTable parse_study_table(std::string_view text, const fs::path& file) {
  StudyTable table;
  int line = 0;
  for (std::size_t start = 0; start < text.size();) {
    const std::size_t end = text.find('\n', start);
    ++line;
    try {
      if (end == std::string_view::npos)
        throw std::invalid_argument("half a line");
      table.rows.push_back(row_from_json(text.substr(start, end - start)));
    } catch (const std::exception& error) {
      if (end != std::string_view::npos && end + 1 < text.size())
        throw InputError({{file.string(), line, "", "a row of a study's table", error.what()}});
      table.is_torn = true;
      break;
    }
    start = end + 1;
  }
  return table;
}

StudyTable read_study_table(const fs::path& file) {
  const std::string text = read_text_file(file, "a table of a study", largest_table);
  return file.extension() == ".csv" ? parse_study_csv(text, file) : parse_study_table(text, file);
}

} // namespace maille::studies
