#pragma once
/// How fast limits are propagated, and how exactly: `studies/lab/run propagate`.

#include "bench/bench_report.hpp"

namespace maille::lab {

/// Boxes of one material against Gibson's chain mail, with the copy bandwidth measured between the runs; four
/// inhomogeneous or non-convex bodies against Dijkstra and enhanced chain mail. One run, medians, one thread
/// unless it says otherwise.
void bench_propagate(const BenchOptions& options, BenchReport& report);

/// Its part on boxes of one material, and its part on the four bodies, adding rows and checks to the report.
/// @return the worst violation of a link, in ulps of float32 of the largest displacement
double bench_homogeneous(const BenchOptions& options, BenchReport& report);
double bench_inhomogeneous(const BenchOptions& options, BenchReport& report);

} // namespace maille::lab
