#pragma once
/// From which sizes on one way is cheaper than another. Changing them changes no answer beyond rounding.

#include "parallel/thread_team.hpp"

#include <cstddef>
#include <cstdint>

namespace maille::deform {

/// Up to this number of nodes, float64 shortest paths take a few milliseconds.
inline constexpr std::int64_t nodes_worth_tiles = 2048;

/// More handles than this are dragged all at once rather than one after the other: each costs a pass over
/// what it moves, scans cost two over everything. Finding out whether a handle reaches all nodes of a body
/// with holes monotonely takes a pass over the body too.
inline constexpr std::size_t most_handles_one_by_one = 4;

} // namespace maille::deform
