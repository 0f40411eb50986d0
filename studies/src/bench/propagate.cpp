#include "bench/propagate.hpp"

namespace maille::studies {

BenchReport bench_propagate(const BenchOptions& options) {
  BenchReport report;
  report.machine = describe_machine();
  const std::size_t bytes =
      options.quick ? 1 << 20 : 192 << 20; // the largest body's coordinates, out of cache
  report.machine["copy_gb_per_s"] = copy_bandwidth(bytes, options.quick ? 1 : 7, 1);
  bench_homogeneous(options, report);
  bench_inhomogeneous(options, report);
  return report;
}

} // namespace maille::studies
