#pragma once
/// How long studies take, and how well what is learnt from them serves: `maille bench studies`.

#include "bench/propagate/propagate.hpp"

namespace maille::studies {

/// One run, each part adding its rows and checks: see choose_checks.hpp, estimate_checks.hpp, study_200.hpp.
BenchReport bench_studies(const BenchOptions& options);

} // namespace maille::studies
