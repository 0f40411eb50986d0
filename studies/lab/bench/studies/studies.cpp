#include "bench/studies/studies.hpp"

namespace maille::lab {

namespace {

void add_estimates(const BenchOptions& options, const Control& control, BenchReport& report) {
  check_estimates(options, control, report);
  check_estimate_kinds(options, control, report);
}

void add_choices(const BenchOptions& options, const Control& control, BenchReport& report) {
  add_choose_checks(options, control, report);
  add_choose_unlike_checks(options, control, report);
}

BenchReport begin() {
  BenchReport report;
  report.machine = describe_machine();
  return report;
}

void end(const Control& control, BenchReport& report) {
  if (control.should_stop())
    report.notes.push_back(
        "interrupted: the last part is incomplete, and what would have followed is missing");
}

} // namespace

BenchReport bench_studies(const BenchOptions& options, const Control& control) {
  BenchReport report = begin();
  bench_study_200(options, report);                              // first: it forks
  const std::size_t bytes = options.quick ? 1 << 20 : 192 << 20; // out of cache
  report.machine["copy_gb_per_s"] = copy_bandwidth(bytes, options.quick ? 1 : 7, 1);
  add_estimates(options, control, report);
  add_choices(options, control, report);
  end(control, report);
  return report;
}

BenchReport bench_estimates(const BenchOptions& options, const Control& control) {
  BenchReport report = begin();
  add_estimates(options, control, report);
  end(control, report);
  return report;
}

BenchReport bench_choices(const BenchOptions& options, const Control& control) {
  BenchReport report = begin();
  add_choices(options, control, report);
  end(control, report);
  return report;
}

} // namespace maille::lab
