#pragma once
/// Whether there is memory for what a method is about to allocate.

#include "maille/scene/answer.hpp"

#include <cstdint>
#include <string>
#include <string_view>

namespace maille::deform {

/// Why a method that needs so many bytes cannot begin; empty if it can.
std::string reason_of_memory(std::string_view method, std::int64_t needed, const Control& control);

/// What stands in memory before the limits of a scene are known: its answer, the kinds of its cells, and the
/// search for the scale of taut limits [bytes].
std::int64_t bytes_at_least(const Scene& scene);

/// What one search for shortest paths from so many ends holds, at most: a length for every grid point, and
/// what waits in its queue.
std::int64_t bytes_of_shortest_paths(const Grid& grid, std::int64_t n_ends);
/// For all that a scene prescribes: lengths from above and from below, and the queue of the search for the
/// second.
std::int64_t bytes_of_two_envelopes(const Scene& scene);

/// What `dijkstra` holds at its peak, at most [bytes].
std::int64_t bytes_for_dijkstra(const Scene& scene);
/// One displacement.
std::int64_t bytes_of_answer(const Scene& scene);
std::int64_t bytes_of_prescribed(const Scene& scene);

} // namespace maille::deform
