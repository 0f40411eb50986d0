#include "bench/propagate/propagate.hpp"

#include <algorithm>

namespace maille::studies {

BenchReport bench_propagate(const BenchOptions& options) {
  BenchReport report;
  report.machine = describe_machine();
  const std::size_t bytes =
      options.quick ? 1 << 20 : 192 << 20; // the largest body's coordinates, out of cache
  report.machine["copy_gb_per_s"] = copy_bandwidth(bytes, options.quick ? 1 : 7, 1);
  const double of_boxes = bench_homogeneous(options, report);
  const double of_hard_bodies = bench_inhomogeneous(options, report);
  // Each link compares two sums of two rounded numbers, so two ulps are rounding.
  report.checks.push_back({"worst_violation_ulp", std::max(of_boxes, of_hard_bodies), 2, false});
  return report;
}

} // namespace maille::studies
