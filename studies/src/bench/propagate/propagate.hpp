#pragma once
/// How fast limits are propagated, and how exactly: `maille bench propagate`.

#include "maille/scene/answer.hpp"
#include "maille/studies/bench_report.hpp"

namespace maille::studies {

struct BenchOptions {
  bool quick = false; ///< small bodies and few repeats: the same path in seconds, figures that mean nothing
};

/// Says where a long benchmark is. @return false if it is to end with what it has
inline bool goes_on(const Control& control, double fraction, std::string_view what) {
  if (control.should_stop())
    return false;
  if (control.progress)
    control.progress(fraction, what);
  return true;
}

/// Boxes of one material against Gibson's chain mail, with the copy bandwidth measured between the runs; four
/// inhomogeneous or non-convex bodies against Dijkstra and enhanced chain mail. One run, medians, one thread
/// unless it says otherwise.
BenchReport bench_propagate(const BenchOptions& options);

/// Its part on boxes of one material, and its part on the four bodies, adding rows and checks to the report.
/// @return the worst violation of a link, in ulps of float32 of the largest displacement
double bench_homogeneous(const BenchOptions& options, BenchReport& report);
double bench_inhomogeneous(const BenchOptions& options, BenchReport& report);

} // namespace maille::studies
