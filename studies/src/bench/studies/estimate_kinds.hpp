#pragma once
/// How far the estimated error can be trusted on scenes of many kinds: part of `maille bench studies`.

#include "maille/studies/bench_report.hpp"

namespace maille::studies {

/// Asks `coupled` about the scenes of kind_scenes (quick: two of them), estimates the errors of its answers,
/// and holds them against quadratic elements: on boxes on cells of half the side, elsewhere the best that ten
/// seconds afford.
///
/// A row a scene, and over the scenes that have an estimate the checks `estimate_kinds_below`, the fraction
/// whose true error is at most the estimated one, and `estimate_kinds_within_2`, whose estimate is within a
/// factor of 2; `estimate_kinds_estimated` is the fraction of scenes that have one.
void check_estimate_kinds(const BenchOptions& options, const Control& control, BenchReport& report);

} // namespace maille::studies
