#include "bench/studies/studies.hpp"

#include "bench/studies/choose_checks.hpp"
#include "bench/studies/choose_unlike.hpp"
#include "bench/studies/estimate_checks.hpp"
#include "bench/studies/estimate_kinds.hpp"
#include "bench/studies/study_200.hpp"

namespace maille::studies {

BenchReport bench_studies(const BenchOptions& options) {
  BenchReport report;
  report.machine = describe_machine();
  bench_study_200(options, report);                              // first: it forks
  const std::size_t bytes = options.quick ? 1 << 20 : 192 << 20; // out of cache
  report.machine["copy_gb_per_s"] = copy_bandwidth(bytes, options.quick ? 1 : 7, 1);
  check_estimates(options, report);
  check_estimate_kinds(options, report);
  add_choose_checks(options, report);
  add_choose_unlike_checks(options, report);
  return report;
}

} // namespace maille::studies
