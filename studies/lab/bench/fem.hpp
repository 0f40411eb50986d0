#pragma once
/// How fast finite elements solve: `studies/lab/run fem`.

#include "bench/bench_report.hpp"

namespace maille::lab {

/// A poked cube by every linear solver that can take its size, each in a process of its own, so that the peak
/// of its memory is known: set-up and solve, and a second load step that keeps factor or hierarchy. One
/// thread; every figure of one run.
void bench_fem(const BenchOptions& options, BenchReport& report);

} // namespace maille::lab
