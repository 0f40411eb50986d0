#pragma once
/// What the methods of this module share: the clock, when to stop, what none of them can carry, and whether
/// there is memory for what they are about to allocate.
///
/// A method asks reason_to_refuse before it allocates, reason_to_stop in every iteration, and ends with a
/// Status and a message in its Answer. Only a programmer's error throws.

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

/// Why no method can carry the moves; empty if they can.
inline std::string reason_of_moves(const Scene& scene) {
  for (const Prescribed& p : scene.prescribed)
    if (!std::isfinite(p.value))
      return "a prescribed displacement is not finite";
  return {};
}

/// Why `method` cannot carry the scene; empty if it can.
inline std::string reason_to_refuse(const Scene& scene, std::string_view method) {
  if (scene.has_loads())
    return std::string(method) +
           " carries no loads: it knows limits of links, not forces; use an elastic method, or moves";
  if (!scene.springs.empty())
    return std::string(method) + " carries no springs to the ground: it knows limits of links, not forces";
  return reason_of_moves(scene);
}

/// Charge for the lists of a scene's own kind: a copy of the prescribed values, as clipped, and reactions.
inline Charge charge_of_clipping(const Scene& scene) {
  return Charge(scene.prescribed.size() * (sizeof(Prescribed) + sizeof(double)));
}

/// Why a method ended that needed more than it was granted.
std::string reason_of_full_arena(std::string_view method, const Control& control);

/// Over all components and nodes, of the absolute values.
inline double largest_entry(const Displacement& displacement) {
  double largest = 0;
  for (const double value : displacement.values())
    largest = std::max(largest, std::abs(value));
  return largest;
}

/// Runs a method within an arena of its own, whose peak the answer tells. Refused is what would pass
/// control.bytes_budget all the same.
template<class Run>
Answer in_arena(std::string_view method, const Control& control, Run&& run) {
  const Arena arena(control.bytes_budget.value_or(Arena::no_limit));
  const Arena::Open open(arena);
  try {
    Answer answer = run();
    answer.bytes = has_displacement(answer.status) ? arena.peak() : 0;
    return answer;
  } catch (const ArenaIsFull&) {
    return refusal(std::string(method), reason_of_full_arena(method, control));
  }
}

/// Why a method that needs `needed` bytes cannot begin; empty if it can.
std::string reason_of_memory(std::string_view method, std::int64_t needed, const Control& control);

/// What stands in memory before the limits of a scene are known: its answer, the kinds of its cells, and the
/// search for the scale of taut limits [bytes].
std::int64_t bytes_at_least(const Scene& scene);

/// Upper bound for one shortest-path search from `n_ends` ends: a length for every grid point, and the queue
/// [bytes].
std::int64_t bytes_of_shortest_paths(const Grid& grid, std::int64_t n_ends);
/// The same for all prescribed values of a scene: lengths from above and from below, and the queue of the
/// second search.
std::int64_t bytes_of_two_envelopes(const Scene& scene);

/// What `dijkstra` holds at its peak, at most [bytes].
std::int64_t bytes_for_dijkstra(const Scene& scene);
/// One displacement.
std::int64_t bytes_of_answer(const Scene& scene);
std::int64_t bytes_of_prescribed(const Scene& scene);

} // namespace maille::deform
