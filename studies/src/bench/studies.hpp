#pragma once
/// How long studies take, and how well what is learnt from them serves: `maille bench studies`.

#include "bench/propagate.hpp"

namespace maille::studies {

/// One run, each part adding its rows and checks.
BenchReport bench_studies(const BenchOptions& options);

/// The anisotropy study of 200 cases on 33^3 nodes: check study_200_seconds. Two cases at a time, one thread each; the reference is
/// solved once a case. Quick: its first cases.
void bench_study_200(const BenchOptions& options, BenchReport& report);

} // namespace maille::studies
