#include "commands.hpp"

#include "bench/fem.hpp"
#include "bench/materials.hpp"
#include "bench/propagate.hpp"
#include "bench/relax.hpp"

#include <algorithm>
#include <thread>

namespace maille::studies {

namespace {

/// What it measures are errors: it takes all threads, says how far it is, and can be stopped.
int bench_materials_command(const BenchCommandOptions& options) {
  const Control control =
      terminal_control(static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
  const BenchReport report = bench_materials({.quick = options.quick}, control);
  end_progress();
  deliver(options.json ? report.json().dump(2) + "\n" : report.table(), options.json);
  return control.should_stop() ? exit_run_failed : exit_done;
}

} // namespace

int bench_command(const BenchCommandOptions& options) {
  prepare_file("--json", options.json);
  if (options.subject == "materials")
    return bench_materials_command(options);
  const auto bench = options.subject == "relax" ? bench_relax
                     : options.subject == "fem" ? bench_fem
                                                : bench_propagate;
  const BenchReport report = bench({.quick = options.quick});
  deliver(options.json ? report.json().dump(2) + "\n" : report.table(), options.json);
  return exit_done;
}

} // namespace maille::studies
