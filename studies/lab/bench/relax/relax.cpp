#include "bench/relax/relax.hpp"

#include <chrono>
#include <ctime>

namespace maille::lab {

void bench_relax(const BenchOptions& options, BenchReport& report) {
  const auto start = std::chrono::steady_clock::now();
  const std::clock_t processor_start = std::clock();
  report.machine = describe_machine();
  const std::size_t bytes = options.quick ? 1 << 20 : 192 << 20; // out of cache, as the largest box
  RelaxFigures figures;
  figures.copy_one = copy_bandwidth(bytes, options.quick ? 1 : 7, 1);
  figures.copy_all = copy_bandwidth(bytes, options.quick ? 1 : 7, 2);
  report.machine["copy_gb_per_s"] = figures.copy_one;
  report.machine["copy_gb_per_s_two_threads"] = figures.copy_all;
  bench_boxes(options, report, figures);
  bench_limits(options, report, figures);
  bench_muscles(options, report, figures);
  add_relax_checks(RelaxSizes::of(options), figures, report);
  // Nearly all of it runs on one thread: what is missing from 1 was taken by neighbours.
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
  report.machine["seconds"] = wall.count();
  report.machine["processor_seconds_over_wall"] =
      static_cast<double>(std::clock() - processor_start) / CLOCKS_PER_SEC / wall.count();
}

} // namespace maille::lab
