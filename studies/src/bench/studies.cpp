#include "bench/studies.hpp"

#include "bench/estimate_checks.hpp"
#include "bench/study_200.hpp"

namespace maille::studies {

BenchReport bench_studies(const BenchOptions& options) {
  BenchReport report;
  report.machine = describe_machine();
  bench_study_200(options, report); // first: it forks
  check_estimates(options, report);
  return report;
}

} // namespace maille::studies
