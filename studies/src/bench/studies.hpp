#pragma once
/// How well studies keep what they promise: `maille bench studies`.

#include "bench/propagate.hpp"

namespace maille::studies {

/// One part a promise; see estimate_checks.hpp. One run, one thread.
BenchReport bench_studies(const BenchOptions& options);

} // namespace maille::studies
