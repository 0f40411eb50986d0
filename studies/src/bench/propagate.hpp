#pragma once
/// How fast limits are propagated, and how exactly: `maille bench propagate`.

#include "maille/studies/bench_report.hpp"

namespace maille::studies {

struct BenchOptions {
  int threads = 1;    ///< besides one, the number that rows are also measured with
  bool quick = false; ///< small bodies and few repeats: the same path in seconds, figures that mean nothing
};

/// Whole-body and local drags, many handles, and four inhomogeneous or non-convex bodies, against Gibson's
/// propagation, Dijkstra, and enhanced chain mail, in one run, with the copy bandwidth measured beside them.
BenchReport bench_propagate(const BenchOptions& options);

// Its parts, each adding rows and checks to the report.
void bench_homogeneous(const BenchOptions& options, BenchReport& report);
void bench_inhomogeneous(const BenchOptions& options, BenchReport& report);

} // namespace maille::studies
