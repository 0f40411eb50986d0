#include "report/report.hpp"

#include "cli/commands.hpp"
#include "export/whole_file.hpp"

#include <fmt/format.h>

#include <fstream>

namespace maille::studies {

namespace {

/// A page is replaced by a page alone: a scene or a table may lie beside the results.
void check_is_page_or_new(const std::filesystem::path& file) {
  if (!std::filesystem::is_regular_file(file) || std::filesystem::file_size(file) == 0)
    return;
  std::string head(1024, '\0');
  std::ifstream(file, std::ios::binary).read(head.data(), static_cast<std::streamsize>(head.size()));
  if (head.find("<meta name=\"generator\" content=\"maille") == std::string::npos)
    throw UsageError(fmt::format(
        "--out {}: expected a new file, or a page that report has written, found another", file.string()));
}

} // namespace

int report_command(const ReportOptions& options) {
  if (!std::filesystem::is_directory(options.folder))
    throw UsageError(fmt::format("OUT: expected a folder of results, found \"{}\"", options.folder.string()));
  const auto file = options.out.empty() ? options.folder / "report.html" : options.out;
  prepare_file("--out", file.string());
  check_is_page_or_new(file);
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
