#include "commands.hpp"

#include "bench/propagate.hpp"

namespace maille::studies {

int bench_command(const BenchCommandOptions& options) {
  prepare_file("--json", options.json);
  const BenchReport report = bench_propagate({.quick = options.quick});
  deliver(options.json ? report.json().dump(2) + "\n" : report.table(), options.json);
  return exit_done;
}

} // namespace maille::studies
