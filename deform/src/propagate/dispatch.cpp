#include "maille/deform/propagate/dispatch.hpp"

#include "maille/deform/propagate/limits.hpp"
#include "maille/deform/propagate/wavefront.hpp"
#include "method.hpp"
#include "propagate/rest_engine.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <set>

namespace maille::deform {

namespace {

std::size_t n_moved(const Scene& scene, int component) {
  return static_cast<std::size_t>(std::ranges::count_if(
      scene.prescribed, [&](const Prescribed& p) { return p.component == component && p.value != 0; }));
}

/// True if the distance from and to every prescribed node is a sum of one term per axis.
bool has_monotone_paths(const Scene& scene) {
  const Specimen& body = scene.specimen;
  if (body.n_matter_cells() == body.grid.n_cells())
    return true;
  std::set<std::int64_t> nodes;
  for (const Prescribed& p : scene.prescribed) {
    nodes.insert(p.node);
    if (nodes.size() > most_handles_in_masked_bodies)
      return false;
  }
  return std::ranges::all_of(
      nodes, [&](std::int64_t node) { return reaches_all_monotonely(body, body.grid.node_at(node)); });
}

bool goes(const Plan& plan, Route route) {
  return std::ranges::find(plan.route, route) != plan.route.end();
}

std::string in_words(const std::array<Route, 3>& routes, int dimension) {
  std::string words;
  for (const Route route : {Route::closed_form, Route::separable_scans, Route::wavefront, Route::dijkstra}) {
    std::string axes;
    for (int b = 0; b < dimension; ++b)
      if (routes[static_cast<std::size_t>(b)] == route)
        axes += axes.empty() ? std::string(1, "xyz"[b]) : fmt::format(" {}", "xyz"[b]);
    if (axes.empty())
      continue;
    const bool is_only = std::ranges::all_of(routes, [&](Route r) { return r == route || r == Route::rest; });
    words += words.empty() ? "" : ", ";
    words += is_only ? std::string(to_string(route)) : fmt::format("{} ({})", to_string(route), axes);
  }
  return words.empty() ? std::string(to_string(Route::rest)) : words;
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
  std::optional<Status> stopped;
  for (int component = 0; component < scene.dimension(); ++component) {
    if (control.progress)
      control.progress(static_cast<double>(component) / scene.dimension(), "propagating");
    stopped = reason_to_stop(control, clock);
    if (stopped)
      break;
    engine.admit(component, prescribed);
    answer.iterations += engine.drag(component, prescribed, answer.displacement);
  }
  clear_where_no_matter_is(scene.specimen, answer.displacement);
  const Admission admission = compare_with_request(scene, std::move(prescribed));
  answer.message = describe(scene, admission);
  answer.status = stopped ? *stopped : admission.n_cut > 0 ? Status::clamped : Status::done;
  answer.bytes = bytes_of(answer.displacement) + engine.bytes() + limits.bytes();
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
  const std::optional<Status> stopped = reason_to_stop(control, clock);
  if (!stopped) {
    prescribed = body.move(scene.prescribed, std::max(1, control.threads));
    body.copy_to(answer.displacement);
  }
  const Admission admission = compare_with_request(scene, std::move(prescribed));
  answer.message = describe(scene, admission);
  answer.status = stopped ? *stopped : admission.n_cut > 0 ? Status::clamped : Status::done;
  answer.iterations = body.n_visits();
  answer.bytes = bytes_of(answer.displacement) + body.bytes() + limits.bytes();
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

/// What the arrays of a way hold beside displacement and limits [bytes].
std::int64_t bytes_of_route(const Scene& scene, const Plan& plan, int threads) {
  const std::int64_t n = scene.specimen.grid.n_nodes();
  if (goes(plan, Route::dijkstra))
    return 2 * n * static_cast<std::int64_t>(sizeof(double));
  if (!goes(plan, Route::wavefront))
    return RestEngine::bytes_for(scene, plan.route, threads);
  // Every tile visited, at the surface or between kinds, and scratch as large as the state for admission.
  const std::int64_t per_node = scene.dimension() * (4 + 4 + 27), per_tile = 64 * scene.dimension();
  const Index3& nodes = scene.specimen.grid.nodes();
  std::int64_t tiles = 1;
  for (const int along : nodes)
    tiles *= (along + 7) / 8;
  return tiles * (512 * per_node + per_tile);
}

} // namespace

std::string_view to_string(Route route) {
  switch (route) {
  case Route::rest:
    return "nothing moves";
  case Route::closed_form:
    return "closed form";
  case Route::separable_scans:
    return "separable scans";
  case Route::wavefront:
    return "tiled wavefront";
  case Route::dijkstra:
    return "Dijkstra per component";
  }
  return "unknown";
}

Plan plan_limits(const Scene& scene, const LinkLimits& limits, int threads) {
  Plan plan;
  const bool has_sums = limits.is_homogeneous() && has_monotone_paths(scene);
  const bool is_box = scene.specimen.n_matter_cells() == scene.specimen.grid.n_cells();
  const Route for_any =
      scene.specimen.grid.n_nodes() < nodes_worth_tiles ? Route::dijkstra : Route::wavefront;
  for (int component = 0; component < scene.dimension(); ++component) {
    const std::size_t n = n_moved(scene, component);
    Route& route = plan.route[static_cast<std::size_t>(component)];
    if (n == 0)
      route = Route::rest;
    else if (!has_sums)
      route = for_any;
    else if (is_box && n > most_handles_one_by_one)
      route = Route::separable_scans;
    else
      route = Route::closed_form;
  }
  plan.algorithm = in_words(plan.route, scene.dimension());
  plan.bytes = scene.dimension() * scene.specimen.grid.n_nodes() * static_cast<std::int64_t>(sizeof(double)) +
               limits.bytes() + bytes_of_route(scene, plan, threads);
  return plan;
}

Answer solve_by_cheapest_way(const Scene& scene, const Control& control) {
  if (std::string reason = reason_to_refuse(scene, "limits"); !reason.empty())
    return refusal("limits", std::move(reason));
  const Clock clock;
  const LinkLimits limits(scene);
  const Plan plan = plan_limits(scene, limits, control.threads);
  if (goes(plan, Route::dijkstra))
    return solve_by_dijkstra(scene, limits, control, clock);
  if (goes(plan, Route::wavefront))
    return solve_by_wavefront(scene, limits, plan, control, clock);
  return solve_homogeneous(scene, limits, plan, control, clock);
}

} // namespace maille::deform
