#include "feasible/feasible_set.hpp"

#include "feasible/bounds/algorithm_sizes.hpp"
#include "feasible/box/rest_engine.hpp"
#include "feasible/limits.hpp"
#include "feasible/wavefront/wavefront.hpp"

#include <algorithm>

namespace maille::deform {

namespace {

bool goes(const Plan& plan, Algorithm algorithm) {
  return std::ranges::find(plan.of_component, algorithm) != plan.of_component.end();
}

void clear_where_no_matter_is(const Specimen& body, Displacement& state) {
  if (body.n_matter_cells() == body.grid.n_cells())
    return;
  for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node)
    if (!body.is_node(body.grid.node_at(node)))
      for (int b = 0; b < body.grid.dimension(); ++b)
        state(b, node) = 0;
}

} // namespace

FeasibleSet::FeasibleSet(const Scene& scene, const LinkLimits& limits, int threads)
    : scene_(scene), limits_(limits), threads_(std::max(1, threads)) {}

bool FeasibleSet::is_homogeneous_box() const {
  return limits_.is_homogeneous() && scene_.specimen.n_matter_cells() == scene_.specimen.grid.n_cells();
}

bool FeasibleSet::is_small() const {
  return scene_.specimen.grid.n_nodes() < nodes_worth_tiles;
}

Clipping FeasibleSet::clip() const {
  const Plan plan = plan_limits(scene_, limits_, threads_);
  if (goes(plan, Algorithm::dijkstra))
    return deform::clip(scene_, limits_);
  if (goes(plan, Algorithm::wavefront))
    return compare_with_request(scene_, TiledBody(scene_, limits_).move(scene_.prescribed, threads_));
  RestEngine engine(scene_, limits_, plan, threads_);
  std::vector<Prescribed> prescribed = scene_.prescribed;
  for (int component = 0; component < scene_.dimension(); ++component)
    engine.clip(component, prescribed);
  return compare_with_request(scene_, std::move(prescribed));
}

std::unique_ptr<DragEngine> FeasibleSet::drag() const {
  return limits_.is_homogeneous() ? make_homogeneous_drag(scene_, limits_, threads_)
                                  : make_tiled_drag(scene_, limits_, threads_);
}

void FeasibleSet::solve_homogeneous(const Plan& plan, const Control& control, const Clock& clock,
                                    Answer& answer) const {
  RestEngine engine(scene_, limits_, plan, threads_);
  answer.seconds.setup = clock.seconds();
  std::vector<Prescribed> prescribed = scene_.prescribed;
  std::optional<Status> stopped;
  for (int component = 0; component < scene_.dimension(); ++component) {
    if (control.progress)
      control.progress(static_cast<double>(component) / scene_.dimension(), "propagating");
    stopped = reason_to_stop(control, clock);
    if (stopped)
      break;
    engine.clip(component, prescribed);
    answer.iterations += engine.drag(component, prescribed, answer.displacement);
  }
  clear_where_no_matter_is(scene_.specimen, answer.displacement);
  tell_clipping(scene_, std::move(prescribed), stopped, answer);
}

void FeasibleSet::solve_by_wavefront(const Control& control, const Clock& clock, Answer& answer) const {
  TiledBody body(scene_, limits_);
  answer.seconds.setup = clock.seconds();
  if (control.progress)
    control.progress(0, "propagating");
  std::vector<Prescribed> prescribed = scene_.prescribed;
  const std::optional<Status> stopped = reason_to_stop(control, clock);
  if (!stopped) {
    body.move_in_place(prescribed, threads_);
    body.copy_to(answer.displacement);
  }
  answer.iterations = body.n_visits();
  tell_clipping(scene_, std::move(prescribed), stopped, answer);
}

Answer FeasibleSet::solve(const Plan& plan, const Control& control, const Clock& clock) const {
  if (goes(plan, Algorithm::dijkstra))
    return limits_from_rest(scene_, limits_, control, clock);
  Answer answer;
  answer.method = "limits";
  answer.algorithm = plan.algorithm;
  answer.displacement = Displacement(scene_.specimen.grid);
  if (goes(plan, Algorithm::wavefront))
    solve_by_wavefront(control, clock, answer);
  else
    solve_homogeneous(plan, control, clock, answer);
  answer.seconds.solve = clock.seconds() - answer.seconds.setup;
  return answer;
}

Answer solve_by_cheapest_way(const Scene& scene, const Control& control) {
  if (std::string reason = reason_to_refuse(scene, "limits"); !reason.empty())
    return refusal("limits", std::move(reason));
  if (std::string reason = reason_of_memory("limits", bytes_at_least(scene), control); !reason.empty())
    return refusal("limits", std::move(reason));
  return in_arena("limits", control, [&] {
    const Clock clock;
    const LinkLimits limits(scene);
    const Plan plan = plan_limits(scene, limits, control.threads);
    // The limits are there already, and no longer part of what is available.
    const std::int64_t held = control.bytes_budget ? 0 : limits.bytes();
    if (std::string reason = reason_of_memory("limits", plan.bytes - held, control); !reason.empty())
      return refusal("limits", std::move(reason));
    return FeasibleSet(scene, limits, control.threads).solve(plan, control, clock);
  });
}

} // namespace maille::deform
