/// Chooses the exact algorithm of each component for `limits`, and forecasts its memory.
///
/// The answer clamps each node between two bounds: the greatest of (value - path length to the handle) and
/// the least of (value + path length), over all handles (docs/theory.md). All algorithms compute these
/// bounds; they differ in how they find shortest paths:
/// rest: no handle moves; closed form: path lengths are sums of one term per axis (equal limits everywhere,
/// monotone paths), one pass per handle; separable scans: the same on a box with many handles, two sweeps in
/// all; wavefront: any body, label-correcting in tiles; Dijkstra: any body, for small ones.
///
/// Exact: all of them, hence the choice affects time and memory only. Heuristic: the sizes at which it
/// switches (algorithm_sizes.hpp).

#include "maille/deform/plan.hpp"
#include "feasible/bounds/algorithm_sizes.hpp"
#include "feasible/bounds/bound_source.hpp"
#include "feasible/forecast.hpp"

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
    if (nodes.size() > most_handles_one_by_one)
      return false;
  }
  return std::ranges::all_of(
      nodes, [&](std::int64_t node) { return reaches_all_monotonely(body, body.grid.node_at(node)); });
}

std::string in_words(const std::array<Algorithm, 3>& algorithms, int dimension) {
  std::string words;
  for (const Algorithm algorithm :
       {Algorithm::closed_form, Algorithm::separable_scans, Algorithm::wavefront, Algorithm::dijkstra}) {
    std::string axes;
    for (int b = 0; b < dimension; ++b)
      if (algorithms[b] == algorithm)
        axes += axes.empty() ? std::string(1, "xyz"[b]) : fmt::format(" {}", "xyz"[b]);
    if (axes.empty())
      continue;
    const bool is_only =
        std::ranges::all_of(algorithms, [&](Algorithm r) { return r == algorithm || r == Algorithm::rest; });
    words += words.empty() ? "" : ", ";
    words += is_only ? std::string(to_string(algorithm)) : fmt::format("{} ({})", to_string(algorithm), axes);
  }
  return words.empty() ? std::string(to_string(Algorithm::rest)) : words;
}

} // namespace

std::string_view to_string(Algorithm algorithm) {
  switch (algorithm) {
  case Algorithm::rest:
    return "nothing moves";
  case Algorithm::closed_form:
    return "closed form";
  case Algorithm::separable_scans:
    return "separable scans";
  case Algorithm::wavefront:
    return "tiled wavefront";
  case Algorithm::dijkstra:
    return "Dijkstra per component";
  }
  return "unknown";
}

Plan plan_limits(const Scene& scene, const LinkLimits& limits, int threads) {
  Plan plan;
  const bool has_sums = limits.is_homogeneous() && has_monotone_paths(scene);
  const bool is_box = scene.specimen.n_matter_cells() == scene.specimen.grid.n_cells();
  const Algorithm for_any =
      scene.specimen.grid.n_nodes() < nodes_worth_tiles ? Algorithm::dijkstra : Algorithm::wavefront;
  for (int component = 0; component < scene.dimension(); ++component) {
    const std::size_t n = n_moved(scene, component);
    Algorithm& algorithm = plan.of_component[component];
    if (n == 0)
      algorithm = Algorithm::rest;
    else if (!has_sums)
      algorithm = for_any;
    else if (is_box && n > most_handles_one_by_one)
      algorithm = Algorithm::separable_scans;
    else
      algorithm = Algorithm::closed_form;
  }
  plan.algorithm = in_words(plan.of_component, scene.dimension());
  plan.arrays = forecast_of_limits(scene, limits, plan.of_component, threads);
  plan.bytes = bytes_of(plan.arrays);
  return plan;
}

} // namespace maille::deform
