#include "report/report.hpp"

#include "cli/commands.hpp"
#include "export/whole_file.hpp"

#include <fmt/format.h>

namespace maille::studies {

int report_command(const ReportOptions& options) {
  if (!std::filesystem::is_directory(options.folder))
    throw UsageError(fmt::format("OUT: expected a folder of results, found \"{}\"", options.folder.string()));
  const auto file = options.out.empty() ? options.folder / "report.html" : options.out;
  prepare_file("--out", file.string());
  // A page is replaced by a page alone: a scene or a table may lie beside the results.
  if (std::filesystem::is_regular_file(file) && !is_own_result(file))
    throw UsageError(fmt::format(
        "--out {}: expected a new file, or a page that report has written, found another", file.string()));
  const auto page_folder = std::filesystem::absolute(file).parent_path();
  const auto links = std::filesystem::proximate(std::filesystem::absolute(options.folder), page_folder);
  const Report report = make_report(options.folder, command_line(), links == "." ? "" : links);
  if (!report.has_results)
    throw UsageError(
        fmt::format("OUT: expected a folder that compare --out, run --out, study, trade or play --out wrote, "
                    "found no results in \"{}\"",
                    options.folder.string()));
  write_whole(file, report.html);
  for (const std::string& note : report.notes)
    fmt::print(stderr, "{}\n", note);
  fmt::print("wrote {}\n", file.string());
  return exit_done;
}

} // namespace maille::studies
