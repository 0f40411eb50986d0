#pragma once
/// How long a study of many cases takes.

#include "bench/propagate.hpp"

namespace maille::studies {

/// The anisotropy study of 200 cases on 33^3 nodes: check study_200_seconds. Two cases at a time, one thread each; the reference is
/// solved once a case. Quick: its first cases.
void bench_study_200(const BenchOptions& options, BenchReport& report);

} // namespace maille::studies
