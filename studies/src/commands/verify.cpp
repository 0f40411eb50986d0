#include "commands.hpp"

#include "maille/studies/export/whole_file.hpp"
#include "maille/studies/verification.hpp"

namespace maille::studies {

int verify_command(const VerifyOptions& options) {
  prepare_file("--json", options.json);
  prepare_file("--markdown", options.markdown);
  const Control control = terminal_control(1);
  VerificationOptions of_run;
  of_run.quick = options.quick;
  of_run.progress = control.progress;
  const std::vector<VerificationRow> rows = verify(of_run);
  const BenchReport report = verification_report(rows, worst_difference_from_calculix());
  end_progress();
  deliver(options.json ? report.json().dump(2) + "\n" : report.table(), options.json);
  if (options.markdown)
    write_whole(*options.markdown, verification_page(report, rows));
  return report.all_met() ? exit_done : exit_verification_failed;
}

} // namespace maille::studies
