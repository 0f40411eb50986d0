#pragma once
/// What it costs to start the command, and to build it for the first picture: `maille bench start`.

#include "maille/studies/bench_report.hpp"

namespace maille::studies {

/// Time and memory of `maille --version`, which opens no plugin, beside those of finite elements' first
/// answer; the objects that scripts/demo compiles. Medians; memory by the kernel's own mark of the process at
/// its end.
void bench_start(const BenchOptions& options, BenchReport& report);

} // namespace maille::studies
