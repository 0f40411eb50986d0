#pragma once
/// How far forces and stress are off: `studies/lab/run mechanics`.

#include "bench/bench_report.hpp"

namespace maille::lab {

/// Forces and stress of `coupled` and `fem_q1` against `fem_q2` on a lattice of half the spacing, of a strip
/// (also at Poisson ratios of 0.45 and 0.49), a block of two tissues, a belly and, with MAILLE_DATA, a muscle
/// of a calf with fibres from diffusion; sums over labels, and what mechanical outputs cost on both legs of a
/// calf. One thread; a few minutes, nearly all of it finite elements.
///
/// Errors of stress are L2 over the eighths of cells (what the reference has one value for), but for cells at
/// edges of holds and moves: raw, one value a cell; recovered, RecoveredFields in the middles of eighths.
void bench_mechanics(const BenchOptions& options, BenchReport& report);

} // namespace maille::lab
