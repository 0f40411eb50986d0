#pragma once
/// How fast limits are propagated, and how exactly: `maille bench propagate`.

#include "maille/studies/bench_report.hpp"

namespace maille::studies {

struct BenchOptions {
  bool quick = false; ///< small bodies and few repeats: the same path in seconds, figures that mean nothing
};

/// Four inhomogeneous or non-convex bodies against Dijkstra and enhanced chain mail, in one run, one thread, with
/// the copy bandwidth measured beside them.
BenchReport bench_propagate(const BenchOptions& options);

/// Its part on those bodies, adding rows and checks to the report.
void bench_inhomogeneous(const BenchOptions& options, BenchReport& report);

} // namespace maille::studies
