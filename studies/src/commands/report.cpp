#include "report/body_pictures.hpp"

#include "cli/commands.hpp"
#include "export/whole_file.hpp"
#include "maille/materials/fault.hpp"
#include "maille/materials/json.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/studies/version.hpp"

#include <fmt/format.h>

namespace maille::studies {
namespace fs = std::filesystem;

namespace {

/// Pictures for each file of results, by name. The page reports invalid files.
nlohmann::ordered_json drawn_for(const fs::path& folder) {
  constexpr std::int64_t largest = std::int64_t{64}
                                   << 20; ///< [bytes], as python/maille/_report_parts.py has it
  nlohmann::ordered_json drawn = nlohmann::ordered_json::object();
  for (const auto& entry : fs::directory_iterator(folder)) {
    const fs::path& file = entry.path();
    if (!file.filename().string().ends_with("_results.json") || !entry.is_regular_file())
      continue;
    try {
      const auto results = parse_json(read_own_text_file(file, "a file of results", largest), file);
      if (const auto& kind = json_entry(results, "kind"); kind == "compare" || kind == "run")
        drawn[file.filename().string()] = drawn_bodies(results, folder);
    } catch (const InputError&) {
      continue;
    }
  }
  return drawn;
}

} // namespace

int report_command(const ReportOptions& options) {
  if (!fs::is_directory(options.folder))
    throw UsageError(fmt::format("OUT: expected a folder of results, found \"{}\"", options.folder.string()));
  const auto file = options.out.empty() ? options.folder / "report.html" : options.out;
  prepare_file("--out", file.string(), {}, ".html");
  return become_python_program("report",
                               {{"folder", options.folder.lexically_normal().string()},
                                {"out", file.string()},
                                {"command", command_line()},
                                {"version", *commit() ? fmt::format("{} ({})", version, commit()) : version},
                                {"drawn", drawn_for(options.folder)}});
}

} // namespace maille::studies
