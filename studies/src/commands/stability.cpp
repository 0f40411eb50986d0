#include "maille/studies/stability.hpp"

#include "cli/commands.hpp"
#include "maille/studies/export/whole_file.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace maille::studies {

namespace {

void check_extremes(const std::vector<std::string>& asked) {
  const std::vector<std::string> known = stability_extremes();
  for (const std::string& extreme : asked)
    if (std::ranges::find(known, extreme) == known.end())
      throw UsageError(
          fmt::format("--only: expected one of \"{}\", found \"{}\"", fmt::join(known, "\", \""), extreme));
}

} // namespace

int stability_command(const StabilityCommandOptions& options) {
  prepare_file("--json", options.json);
  prepare_file("--markdown", options.markdown);
  check_extremes(options.extremes);
  const Control control = terminal_control(options.threads);
  const Stability result = stability({.quick = options.quick, .extremes = options.extremes}, control);
  const BenchReport report = stability_report(result);
  end_progress();
  deliver(options.json ? json_text(report.json()) : report.table(), options.json);
  if (control.should_stop())
    return exit_run_failed;
  if (options.markdown)
    write_whole(*options.markdown, stability_page(result));
  const bool is_broken = std::ranges::any_of(
      report.checks, [](const BenchCheck& check) { return check.name.ends_with("_broken") && !check.met(); });
  return is_broken ? exit_verification_failed : exit_done;
}

} // namespace maille::studies
