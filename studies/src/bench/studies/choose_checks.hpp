#pragma once
/// How often choose() keeps its word on scenes that it has not seen: a part of `maille bench studies`.

#include "maille/studies/bench_report.hpp"

namespace maille::studies {

/// Draws unseen scenes with a fixed seed, asks choose() with the built-in table for a random wish each, does
/// what it chose, and measures that against the best reference: error as it comes, time as the median of
/// three. Goes on until 56 scenes have got a promise (6 with options.quick), or 300 seconds of the processor
/// are over. Promises of less error than the reference's own cannot be judged and are passed over. Adds a row
/// a promise, and the checks choose_error_kept, choose_time_kept (parts of the promises) and choose_scenes
/// (promises).
void add_choose_checks(const BenchOptions& options, const Control& control, BenchReport& report);

} // namespace maille::studies
