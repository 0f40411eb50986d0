#pragma once
/// How fast bodies are answered that are no boxes: `studies/lab/run bodies`.

#include "bench/bench_report.hpp"

namespace maille::lab {

/// Muscles from images and generated ones, networks, bone from CT and layers of tissue, by `coupled` to three
/// tolerances, each checked against a tight answer, against deal.II's quickest solver at the same error;
/// within limits of the materials; on two threads; a second frame; what contrast and thin matter cost. One
/// thread unless a row says otherwise, medians. Memory is Answer::bytes. Some twenty minutes, most of it
/// finite elements.
void bench_bodies(const BenchOptions& options, BenchReport& report);

} // namespace maille::lab
