#pragma once
/// What it costs to carry images along, and how exact that is, beside a program that medical users have:
/// `studies/lab/run ecosystem`.

#include "bench/bench_report.hpp"

namespace maille::lab {

/// A smoothly deformed body: the residual of its pull field, the volumes of its labels, and the time beside
/// that of plastimatch where that is installed; two bars that slide along each other. One thread, medians.
void bench_ecosystem(const BenchOptions& options, BenchReport& report);

} // namespace maille::lab
