#pragma once
/// Which of several trade-offs are worth having.

#include <cstddef>
#include <span>
#include <vector>

namespace maille::studies {

/// One way to answer: what it costs and how far off it is; less is better in both.
struct CostAndError {
  double cost = 0, error = 0;
};

/// The points that no other is as good as in both and better in one, from the cheapest to the dearest. Points
/// that are alike are all in it; one with a coordinate that is not finite is in none.
/// Cost  O(n log n)
std::vector<std::size_t> pareto_front(std::span<const CostAndError> points);

} // namespace maille::studies
