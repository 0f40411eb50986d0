#pragma once
/// How long the anisotropy study of 200 cases takes: part of `maille bench studies`.

#include "maille/studies/bench_report.hpp"

namespace maille::studies {

/// The study of studies/anisotropy/cube_200.toml, on 33^3 nodes: check study_200_seconds. Two cases at a
/// time, one thread each; the reference is solved once a case. Quick: its first two cases.
/// @pre  this process has started no threads: cases run in processes forked from it
void bench_study_200(const BenchOptions& options, BenchReport& report);

} // namespace maille::studies
