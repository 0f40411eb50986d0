#include "commands.hpp"

#include "bench/fem.hpp"

namespace maille::studies {

int bench_command(const BenchCommandOptions& options) {
  prepare_file("--json", options.json);
  const BenchOptions of_run{.quick = options.quick};
  const BenchReport report = options.subject == "fem" ? bench_fem(of_run) : bench_propagate(of_run);
  deliver(options.json ? report.json().dump(2) + "\n" : report.table(), options.json);
  return exit_done;
}

} // namespace maille::studies
