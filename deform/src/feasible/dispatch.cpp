#include "maille/deform/plan.hpp"

#include "control/method.hpp"
#include "feasible/box/rest_engine.hpp"
#include "feasible/limits.hpp"
#include "feasible/wavefront/wavefront.hpp"

#include <algorithm>

namespace maille::deform {

namespace {

bool goes(const Plan& plan, Algorithm algorithm) {
  return std::ranges::find(plan.of_component, algorithm) != plan.of_component.end();
}

/// The state of a body without motion, which obeys every limit, and what the answer says beside it.
Answer resting_answer(const Scene& scene, const Plan& plan) {
  Answer answer;
  answer.method = "limits";
  answer.algorithm = plan.algorithm;
  answer.displacement = Displacement(scene.specimen.grid);
  return answer;
}

void clear_where_no_matter_is(const Specimen& body, Displacement& state) {
  if (body.n_matter_cells() == body.grid.n_cells())
    return;
  for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node)
    if (!body.is_node(body.grid.node_at(node)))
      for (auto& component : state.component)
        component[static_cast<std::size_t>(node)] = 0;
}

Answer solve_homogeneous(const Scene& scene, const LinkLimits& limits, const Plan& plan,
                         const Control& control, const Clock& clock) {
  Answer answer = resting_answer(scene, plan);
  RestEngine engine(scene, limits, plan, control.threads);
  answer.seconds.setup = clock.seconds();
  std::vector<Prescribed> prescribed = scene.prescribed;
  answer.bytes = bytes_of(answer.displacement) + limits.bytes() + bytes_of(prescribed);
  std::optional<Status> stopped;
  for (int component = 0; component < scene.dimension(); ++component) {
    if (control.progress)
      control.progress(static_cast<double>(component) / scene.dimension(), "propagating");
    stopped = reason_to_stop(control, clock);
    if (stopped)
      break;
    engine.clip(component, prescribed);
    answer.iterations += engine.drag(component, prescribed, answer.displacement);
  }
  clear_where_no_matter_is(scene.specimen, answer.displacement);
  const Clipping clipping = compare_with_request(scene, std::move(prescribed));
  answer.message = describe(scene, clipping);
  answer.n_cut = clipping.n_cut;
  answer.status = stopped ? *stopped : clipping.n_cut > 0 ? Status::clamped : Status::done;
  answer.bytes += engine.bytes();
  answer.seconds.solve = clock.seconds() - answer.seconds.setup;
  return answer;
}

Answer solve_by_wavefront(const Scene& scene, const LinkLimits& limits, const Plan& plan,
                          const Control& control, const Clock& clock) {
  Answer answer = resting_answer(scene, plan);
  TiledBody body(scene, limits);
  answer.seconds.setup = clock.seconds();
  if (control.progress)
    control.progress(0, "propagating");
  std::vector<Prescribed> prescribed = scene.prescribed;
  answer.bytes = bytes_of(answer.displacement) + limits.bytes() + bytes_of(prescribed);
  const std::optional<Status> stopped = reason_to_stop(control, clock);
  if (!stopped) {
    body.move_in_place(prescribed, std::max(1, control.threads));
    body.copy_to(answer.displacement);
  }
  const Clipping clipping = compare_with_request(scene, std::move(prescribed));
  answer.message = describe(scene, clipping);
  answer.n_cut = clipping.n_cut;
  answer.status = stopped ? *stopped : clipping.n_cut > 0 ? Status::clamped : Status::done;
  answer.iterations = body.n_visits();
  answer.bytes += body.bytes();
  answer.seconds.solve = clock.seconds() - answer.seconds.setup;
  return answer;
}

Answer solve_by_dijkstra(const Scene& scene, const LinkLimits& limits, const Control& control,
                         const Clock& clock) {
  const double setup = clock.seconds();
  Control rest_of_control = control;
  if (control.seconds_budget)
    rest_of_control.seconds_budget = *control.seconds_budget - setup;
  Answer answer = drag_limits(scene, limits, Displacement(scene.specimen.grid), rest_of_control);
  answer.seconds.setup = setup;
  return answer;
}

} // namespace

Answer solve_by_cheapest_way(const Scene& scene, const Control& control) {
  if (std::string reason = reason_to_refuse(scene, "limits"); !reason.empty())
    return refusal("limits", std::move(reason));
  if (std::string reason = reason_of_memory("limits", bytes_at_least(scene), control); !reason.empty())
    return refusal("limits", std::move(reason));
  const Clock clock;
  const LinkLimits limits(scene);
  const Plan plan = plan_limits(scene, limits, control.threads);
  // The limits are there already, and no longer part of what is available.
  const std::int64_t held = control.bytes_budget ? 0 : limits.bytes();
  if (std::string reason = reason_of_memory("limits", plan.bytes - held, control); !reason.empty())
    return refusal("limits", std::move(reason));
  if (goes(plan, Algorithm::dijkstra))
    return solve_by_dijkstra(scene, limits, control, clock);
  if (goes(plan, Algorithm::wavefront))
    return solve_by_wavefront(scene, limits, plan, control, clock);
  return solve_homogeneous(scene, limits, plan, control, clock);
}

} // namespace maille::deform
