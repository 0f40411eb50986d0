#pragma once
/// Columns of a comparison, for all output formats.

#include "compare/comparison.hpp"
#include "maille/scene/mechanics/mechanics.hpp"
#include "results/result_table.hpp"

namespace maille::studies {

/// A row with the context that its columns require.
struct ComparisonLine {
  const Scene* scene;
  const Comparison* comparison;
  const ComparisonRow* row;
  std::optional<TestResult> test{}; ///< if the scene has a test and the method has forces
};

const ResultTable<ComparisonLine>& columns_of_comparison();

} // namespace maille::studies
