#pragma once
/// Sizes at which one algorithm becomes cheaper than another. They change answers by rounding only.

#include "parallel/thread_team.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace maille::deform {

/// Up to this number of nodes, float64 shortest paths take a few milliseconds.
inline constexpr std::int64_t nodes_worth_tiles = 2048;

/// More handles than this are dragged together: a handle by itself costs a pass over the nodes that it moves,
/// scans cost two passes over the body. In bodies with holes, the test for monotone paths costs another pass.
inline constexpr std::size_t most_handles_one_by_one = 4;

/// Threads that a body of this size can use.
inline int useful_threads(std::int64_t n_nodes, int threads) {
  return n_nodes < nodes_worth_a_thread ? 1 : std::max(1, threads);
}

} // namespace maille::deform
