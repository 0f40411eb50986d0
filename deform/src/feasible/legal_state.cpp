#include "feasible/legal_state.hpp"

#include "feasible/bounds/route_sizes.hpp"
#include "feasible/box/rest_engine.hpp"
#include "feasible/limits.hpp"
#include "feasible/repair.hpp"
#include "feasible/wavefront/wavefront.hpp"
#include "maille/deform/plan.hpp"

#include <algorithm>
#include <cmath>

namespace maille::deform {

namespace {

bool is_homogeneous_box(const Scene& scene, const LinkLimits& limits) {
  return limits.is_homogeneous() && scene.specimen.n_matter_cells() == scene.specimen.grid.n_cells();
}

bool goes(const Plan& plan, Route route) {
  return std::ranges::find(plan.route, route) != plan.route.end();
}

std::int64_t clamp_box(const Scene& scene, const LinkLimits& limits,
                       const std::vector<Prescribed>& prescribed, Displacement& state, int threads) {
  const Grid& grid = scene.specimen.grid;
  ThreadTeam team(grid.n_nodes() < nodes_worth_a_thread ? 1 : std::max(1, threads));
  SeparableScans<double> scans(grid, step_bounds(scene, limits), team.threads());
  std::vector<HandleValue> handles;
  Rounding rounding;
  for (int component = 0; component < scene.dimension(); ++component) {
    handles.clear();
    for (const Prescribed& p : prescribed)
      if (p.component == component && state(component, p.node) != p.value)
        handles.push_back({grid.node_at(p.node), p.value});
    std::vector<double>& u = state.component[static_cast<std::size_t>(component)];
    for (const double value : u)
      rounding.largest = std::max(rounding.largest, std::abs(value));
    scans.add(component, dense_field(grid, u.data()), handles, rounding);
  }
  scans.run(team);
  return scans.bytes();
}

} // namespace

Admission admit_fast(const Scene& scene, const LinkLimits& limits, int threads) {
  const Plan plan = plan_limits(scene, limits, threads);
  if (goes(plan, Route::dijkstra))
    return admit(scene, limits);
  if (goes(plan, Route::wavefront))
    return compare_with_request(scene, TiledBody(scene, limits).move(scene.prescribed, std::max(1, threads)));
  RestEngine engine(scene, limits, plan, threads);
  std::vector<Prescribed> prescribed = scene.prescribed;
  for (int component = 0; component < scene.dimension(); ++component)
    engine.admit(component, prescribed);
  return compare_with_request(scene, std::move(prescribed));
}

std::int64_t make_legal(const Scene& scene, const LinkLimits& limits,
                        const std::vector<Prescribed>& prescribed, Displacement& state, int threads) {
  const bool is_small = scene.specimen.grid.n_nodes() < nodes_worth_tiles;
  std::int64_t bytes = 0;
  if (is_homogeneous_box(scene, limits)) {
    repair(scene, limits, state, threads);
    bytes = scene.specimen.grid.n_nodes() * std::int64_t{sizeof(double)};
    bytes = std::max(bytes, clamp_box(scene, limits, prescribed, state, threads));
  } else if (is_small) {
    repair(scene, limits, state, threads);
    propagate(scene, limits, prescribed, state);
    bytes = 2 * scene.specimen.grid.n_nodes() * std::int64_t{sizeof(double)};
  } else {
    TiledBody body(scene, limits);
    body.set_state(state);
    body.move(prescribed, std::max(1, threads));
    body.copy_to(state);
    bytes = body.bytes();
  }
  for (const Prescribed& p : prescribed) // to the last bit
    state(p.component, p.node) = p.value;
  return bytes;
}

} // namespace maille::deform
