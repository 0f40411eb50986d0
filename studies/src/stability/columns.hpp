#pragma once
/// What a row of `maille stability` holds, in every form.

#include "maille/studies/stability.hpp"
#include "results/result_table.hpp"

namespace maille::studies {

const ResultTable<StabilityCell>& columns_of_stability();

} // namespace maille::studies
