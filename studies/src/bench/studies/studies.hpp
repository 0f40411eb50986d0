#pragma once
/// How long studies take, and how well what is learnt from them serves: `maille bench studies`.

#include "maille/studies/bench_report.hpp"

namespace maille::studies {

/// One run, each part adding its rows and checks: see choose_checks.hpp, choose_unlike.hpp,
/// estimate_checks.hpp, estimate_kinds.hpp, study_200.hpp. An hour and more; interrupted, it reports what it
/// has.
BenchReport bench_studies(const BenchOptions& options, const Control& control);

/// Its parts on estimated errors, and on promises, alone.
BenchReport bench_estimates(const BenchOptions& options, const Control& control);
BenchReport bench_choices(const BenchOptions& options, const Control& control);

} // namespace maille::studies
