#pragma once
/// How `choose` keeps its word on scenes that its table knows nothing of: part of `maille bench studies`.

#include "maille/studies/bench_report.hpp"

namespace maille::studies {

/// Asks for 5, 10, 20 and 40 % by turns on the scenes of unlike_scenes (quick: two of them), does what was
/// chosen, and holds it against the best reference that a minute affords; promises whose reference is
/// not known to be within the wish are not counted.
///
/// A row a promise, and the checks `choose_unlike_kept`, the fraction of promises whose error is within the
/// wish, and `choose_unlike_refused`, the fraction of scenes on which nothing was promised.
void add_choose_unlike_checks(const BenchOptions& options, const Control& control, BenchReport& report);

} // namespace maille::studies
