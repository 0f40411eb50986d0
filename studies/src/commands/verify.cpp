

#include "cli/commands.hpp"
#include "maille/fem_ref/ranks.hpp"
#include "maille/studies/export/whole_file.hpp"
#include "maille/studies/stability.hpp"
#include "maille/studies/verification.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace maille::studies {

int verify_command(const VerifyOptions& options) {
  if (options.ranks) {
    const double of_elements = worst_difference_between_ranks(),
                 of_coupled = worst_coupled_difference_between_ranks();
    if (fem_ref::ranks().is_first())
      deliver(fmt::format("{} {}\n", of_elements, of_coupled), std::nullopt);
    return exit_done;
  }
  prepare_file("--json", options.json);
  prepare_file("--markdown", options.markdown);
  const Control control = terminal_control(1);
  VerificationOptions of_run;
  of_run.quick = options.quick;
  of_run.progress = control.progress;
  const std::vector<VerificationRow> rows = verify(of_run);
  const auto of_ranks = differences_of_two_ranks(std::filesystem::read_symlink("/proc/self/exe"));
  const BenchReport report =
      verification_report(rows, worst_difference_from_calculix(),
                          of_ranks ? std::optional(of_ranks->finite_elements) : std::nullopt);
  end_progress();
  deliver(options.json ? json_text(report.json()) : report.table(), options.json);
  if (options.markdown)
    write_whole(*options.markdown, verification_page(report, rows));
  return report.all_met() ? exit_done : exit_verification_failed;
}

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
