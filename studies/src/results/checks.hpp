#pragma once
/// Figures that were aimed for, as a table.

#include "maille/studies/bench_report.hpp"
#include "results/result_table.hpp"

namespace maille::studies {

const ResultTable<BenchCheck>& columns_of_checks();

} // namespace maille::studies
