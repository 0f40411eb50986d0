#include "maille/deform/propagate/dispatch.hpp"

#include "maille/deform/propagate/limits.hpp"
#include "method.hpp"
#include "propagate/rest_engine.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <set>

namespace maille::deform {

namespace {

/// To find out whether a handle reaches all nodes monotonely takes a pass over the body.
constexpr std::size_t most_handles_in_masked_bodies = 4;

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

bool goes(const Plan& plan, Way way) {
  return std::ranges::find(plan.way, way) != plan.way.end();
}

std::string in_words(const std::array<Way, 3>& ways, int dimension) {
  std::string words;
  for (const Way way : {Way::closed_form, Way::separable_scans, Way::dijkstra}) {
    std::string axes;
    for (int b = 0; b < dimension; ++b)
      if (ways[static_cast<std::size_t>(b)] == way)
        axes += axes.empty() ? std::string(1, "xyz"[b]) : fmt::format(" {}", "xyz"[b]);
    if (axes.empty())
      continue;
    const bool is_only = std::ranges::all_of(ways, [&](Way w) { return w == way || w == Way::rest; });
    words += words.empty() ? "" : ", ";
    words += is_only ? std::string(to_string(way)) : fmt::format("{} ({})", to_string(way), axes);
  }
  return words.empty() ? std::string(to_string(Way::rest)) : words;
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

} // namespace

std::string_view to_string(Way way) {
  switch (way) {
  case Way::rest:
    return "nothing moves";
  case Way::closed_form:
    return "closed form";
  case Way::separable_scans:
    return "separable scans";
  case Way::dijkstra:
    return "Dijkstra per component";
  }
  return "unknown";
}

Plan plan_limits(const Scene& scene, const LinkLimits& limits, int threads) {
  Plan plan;
  const bool has_sums = limits.is_homogeneous() && has_monotone_paths(scene);
  const bool is_box = scene.specimen.n_matter_cells() == scene.specimen.grid.n_cells();
  for (int component = 0; component < scene.dimension(); ++component) {
    const std::size_t n = n_moved(scene, component);
    plan.way[static_cast<std::size_t>(component)] = n == 0      ? Way::rest
                                                    : !has_sums ? Way::dijkstra
                                                    : n <= most_handles_one_by_one || !is_box
                                                        ? Way::closed_form
                                                        : Way::separable_scans;
  }
  plan.algorithm = in_words(plan.way, scene.dimension());
  const Grid& grid = scene.specimen.grid;
  const auto field_bytes = grid.n_nodes() * static_cast<std::int64_t>(sizeof(double));
  plan.bytes =
      scene.dimension() * field_bytes + limits.bytes() +
      (goes(plan, Way::dijkstra) ? 2 * field_bytes : RestEngine::bytes_for(scene, plan.way, threads));
  return plan;
}

Answer solve_by_cheapest_way(const Scene& scene, const Control& control) {
  if (std::string reason = reason_to_refuse(scene, "limits"); !reason.empty())
    return refusal("limits", std::move(reason));
  const Clock clock;
  const LinkLimits limits(scene);
  const Plan plan = plan_limits(scene, limits, control.threads);
  if (!goes(plan, Way::dijkstra))
    return solve_homogeneous(scene, limits, plan, control, clock);
  const double setup = clock.seconds();
  Control rest_of_control = control;
  if (control.seconds_budget)
    rest_of_control.seconds_budget = *control.seconds_budget - setup;
  Answer answer = drag_limits(scene, limits, Displacement(scene.specimen.grid), rest_of_control);
  answer.seconds.setup = setup;
  return answer;
}

} // namespace maille::deform
