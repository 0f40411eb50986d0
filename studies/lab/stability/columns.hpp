#pragma once
/// What a row of `studies/lab/run stability` holds, in every form.

#include "results/result_table.hpp"
#include "stability/stability.hpp"

namespace maille::lab {

const ResultTable<StabilityCell>& columns_of_stability();

} // namespace maille::lab
