#include "bench/studies.hpp"

#include "bench/estimate_checks.hpp"
#include "bench/study_200.hpp"

namespace maille::studies {

BenchReport bench_studies(const BenchOptions& options) {
  BenchReport report;
  report.machine = describe_machine();
  const std::size_t bytes = options.quick ? 1 << 20 : 192 << 20; // out of cache
  const int repeats = options.quick ? 1 : 7;
  report.machine["copy_gb_per_s"] = copy_bandwidth(bytes, repeats, 1);
  check_estimates(options, report);
  bench_study_200(options, report);
  return report;
}

} // namespace maille::studies
