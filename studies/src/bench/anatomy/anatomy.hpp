#pragma once
/// Conditions where anatomy is, surfaces that run through cells, borders that slide, and constants from
/// measurements, against what is known: `maille bench anatomy`.

#include "maille/studies/bench_report.hpp"

namespace maille::studies {

/// Rows and checks of docs/anatomy.md. One thread; about a minute. Nothing needs MAILLE_DATA.
void bench_anatomy(const BenchOptions& options, BenchReport& report);

/// The rows of bench_anatomy that find constants. @return the checks
std::vector<BenchCheck> bench_identify(const BenchOptions& options, BenchReport& report);

} // namespace maille::studies
