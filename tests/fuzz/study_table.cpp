/// Tables of studies, which --resume and merge read: CSV where the input begins as such a table, JSON lines
/// otherwise. What is read is written and read again.

#include "maille/studies/study_table.hpp"
#include "fuzzing.hpp"
#include "maille/scene/read_scene.hpp"

#include <nlohmann/json.hpp>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  maille::set_file_scope(maille::FileScope::sandbox); // what is tried reads nothing but fixtures
  using namespace maille;
  const std::string_view text = fuzzing::text_of(data, size);
  return fuzzing::tried([&] {
    const auto table = text.starts_with("study,") ? studies::parse_study_csv(text, "table.csv")
                                                  : studies::parse_study_table(text, "table.jsonl");
    for (const studies::StudyRow& row : table.rows) {
      const std::string line = studies::json_line(row);
      fuzzing::require(studies::json_line(studies::row_from_json(line)) == line,
                       "rows read back as they were");
    }
  });
}
