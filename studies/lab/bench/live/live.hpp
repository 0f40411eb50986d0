#pragma once
/// How soon the hand sees what it does: `studies/lab/run live`.

#include "bench/bench_report.hpp"

namespace maille::lab {

/// Hands of events in a window (on a display, else headless: a note says which), in real time, two threads of
/// methods and pictures: from event to picture, the loop at 1 kHz, processor time when nothing moves, a
/// session replayed.
void bench_live(const BenchOptions& options, BenchReport& report);

} // namespace maille::lab
