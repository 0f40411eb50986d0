#pragma once
/// What a row of a comparison holds, in every form.

#include "compare/comparison.hpp"
#include "maille/scene/mechanics/mechanics.hpp"
#include "results/result_table.hpp"

namespace maille::studies {

/// A row with what its columns need to know beside it.
struct ComparisonLine {
  const Scene* scene;
  const Comparison* comparison;
  const ComparisonRow* row;
  std::optional<TestResult> test{}; ///< where the scene has one, and the method forces
};

const ResultTable<ComparisonLine>& columns_of_comparison();

} // namespace maille::studies
