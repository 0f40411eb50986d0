#pragma once
/// What the methods of this module share: the clock, when to stop, what none of them can carry, and whether
/// there is memory for what they are about to allocate.

#include "maille/scene/answer.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace maille::deform {

class Clock {
public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Why a method must end now, if it must.
inline std::optional<Status> reason_to_stop(const Control& control, const Clock& clock) {
  if (control.should_stop())
    return Status::interrupted;
  if (control.seconds_budget && clock.seconds() > *control.seconds_budget)
    return Status::budget_reached;
  return std::nullopt;
}

/// Why `method` cannot carry the scene; empty if it can.
inline std::string reason_to_refuse(const Scene& scene, std::string_view method) {
  if (scene.has_loads())
    return std::string(method) +
           " carries no loads: it knows limits of links, not forces; use an elastic method, or moves";
  for (const Prescribed& p : scene.prescribed)
    if (!std::isfinite(p.value))
      return "a prescribed displacement is not finite";
  return {};
}

inline std::int64_t bytes_of(const std::vector<Prescribed>& list) {
  return static_cast<std::int64_t>(list.capacity() * sizeof(Prescribed));
}

inline std::int64_t bytes_of(const Displacement& displacement) {
  return static_cast<std::int64_t>(displacement.values().size_bytes());
}

/// Over all components and nodes, of the absolute values.
inline double largest_entry(const Displacement& displacement) {
  double largest = 0;
  for (const double value : displacement.values())
    largest = std::max(largest, std::abs(value));
  return largest;
}

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
