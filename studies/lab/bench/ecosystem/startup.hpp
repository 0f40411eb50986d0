#pragma once
/// What it costs to start the command, and to build it for the first picture: of `studies/lab/run ecosystem`.

#include "bench/bench_report.hpp"

namespace maille::lab {

/// Time and memory of `maille --version`, which opens no plugin, beside those of finite elements' first
/// answer; the objects that scripts/demo compiles. Medians; memory by the kernel's own mark of the process at
/// its end. To be asked first: of a program that holds much a fork takes longer than what it starts.
void bench_start(const BenchOptions& options, BenchReport& report);

} // namespace maille::lab
