#include "commands.hpp"

#include "bench/fem.hpp"
#include "bench/propagate.hpp"
#include "bench/relax.hpp"
#include "bench/studies.hpp"

namespace maille::studies {

int bench_command(const BenchCommandOptions& options) {
  prepare_file("--json", options.json);
  const auto bench = options.subject == "relax"     ? bench_relax
                     : options.subject == "fem"     ? bench_fem
                     : options.subject == "studies" ? bench_studies
                                                    : bench_propagate;
  const BenchReport report = bench({.quick = options.quick});
  deliver(options.json ? report.json().dump(2) + "\n" : report.table(), options.json);
  return exit_done;
}

} // namespace maille::studies
