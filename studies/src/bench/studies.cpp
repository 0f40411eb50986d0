#include "bench/studies.hpp"

#include "bench/estimate_checks.hpp"

namespace maille::studies {

BenchReport bench_studies(const BenchOptions& options) {
  BenchReport report;
  report.machine = describe_machine();
  check_estimates(options, report);
  return report;
}

} // namespace maille::studies
