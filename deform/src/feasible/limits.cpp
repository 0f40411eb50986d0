#include "feasible/limits.hpp"

#include "feasible/bounds/bound_source.hpp"

#include <algorithm>

namespace maille::deform {

namespace {

std::int64_t n_reached(const List<double>& envelope) {
  return std::ranges::count_if(envelope, [](double value) { return std::isfinite(value); });
}

/// One component of propagate().
std::int64_t propagate_component(const Scene& scene, const LinkLimits& limits, int component,
                                 const std::vector<Prescribed>& prescribed, Displacement& state) {
  const auto ends = path_ends(prescribed, component, [](const Prescribed&) { return true; });
  // A feasible state that has the prescribed values already lies between L and U.
  if (std::ranges::all_of(ends, [&](const PathEnd& e) { return state(component, e.node) == e.potential; }))
    return 0;
  const List<double> highest = upper_envelope(scene, limits, component, ends);
  const List<double> lowest = lower_envelope(scene, limits, component, ends);
  const std::span<double> u = state.component(component);
  for (std::size_t i = 0; i < u.size(); ++i)
    u[i] = std::min(std::max(u[i], lowest[i]), highest[i]); // defined even if rounding crosses the bounds
  for (const PathEnd& end : ends)
    state(component, end.node) = end.potential;
  return n_reached(highest) + n_reached(lowest);
}

} // namespace

std::int64_t propagate(const Scene& scene, const LinkLimits& limits,
                       const std::vector<Prescribed>& prescribed, Displacement& state) {
  std::int64_t settled = 0;
  for (int component = 0; component < scene.dimension(); ++component)
    settled += propagate_component(scene, limits, component, prescribed, state);
  return settled;
}

Answer drag_limits(const Scene& scene, const LinkLimits& limits, Displacement start, const Control& control) {
  if (std::string reason = reason_to_refuse(scene, "limits"); !reason.empty())
    return refusal("limits", std::move(reason));
  const Clock clock;
  Answer answer;
  answer.method = "limits";
  answer.algorithm = "Dijkstra per component";
  answer.displacement = std::move(start);
  std::vector<Prescribed> prescribed = scene.prescribed;
  std::optional<Status> stopped;
  for (int component = 0; component < scene.dimension() && !stopped; ++component) {
    if (control.progress)
      control.progress(static_cast<double>(component) / scene.dimension(), "propagating");
    stopped = reason_to_stop(control, clock);
    if (stopped)
      break;
    clip_component(scene, limits, component, prescribed);
    answer.iterations += propagate_component(scene, limits, component, prescribed, answer.displacement);
  }
  tell_clipping(scene, std::move(prescribed), stopped, answer);
  answer.seconds.solve = clock.seconds();
  return answer;
}

Answer limits_from_rest(const Scene& scene, const LinkLimits& limits, const Control& control,
                        const Clock& clock) {
  const double setup = clock.seconds();
  Control rest_of_control = control;
  if (control.seconds_budget)
    rest_of_control.seconds_budget = *control.seconds_budget - setup;
  Answer answer = drag_limits(scene, limits, Displacement(scene.specimen.grid), rest_of_control);
  answer.seconds.setup = setup;
  return answer;
}

Answer solve_limits(const Scene& scene, const Control& control) {
  if (std::string reason = reason_to_refuse(scene, "limits"); !reason.empty())
    return refusal("limits", std::move(reason));
  return in_arena("limits", control, [&] {
    const Clock clock;
    const LinkLimits limits(scene);
    return limits_from_rest(scene, limits, control, clock);
  });
}

} // namespace maille::deform
