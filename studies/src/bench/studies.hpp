#pragma once
/// How well choices keep their word: `maille bench studies`.

#include "bench/propagate.hpp"

namespace maille::studies {

BenchReport bench_studies(const BenchOptions& options);

} // namespace maille::studies
