#include "feasible/projection.hpp"

#include "feasible/bounds/algorithm_sizes.hpp"
#include "feasible/bounds/bound_source.hpp"
#include "feasible/box/rest_engine.hpp"
#include "feasible/limits.hpp"
#include "feasible/wavefront/wavefront.hpp"
#include "maille/deform/plan.hpp"
#include "parallel/thread_team.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

namespace maille::deform {

namespace {

bool is_homogeneous_box(const Scene& scene, const LinkLimits& limits) {
  return limits.is_homogeneous() && scene.specimen.n_matter_cells() == scene.specimen.grid.n_cells();
}

bool goes(const Plan& plan, Algorithm algorithm) {
  return std::ranges::find(plan.of_component, algorithm) != plan.of_component.end();
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

Clipping clip_fast(const Scene& scene, const LinkLimits& limits, int threads) {
  const Plan plan = plan_limits(scene, limits, threads);
  if (goes(plan, Algorithm::dijkstra))
    return clip(scene, limits);
  if (goes(plan, Algorithm::wavefront))
    return compare_with_request(scene, TiledBody(scene, limits).move(scene.prescribed, std::max(1, threads)));
  RestEngine engine(scene, limits, plan, threads);
  std::vector<Prescribed> prescribed = scene.prescribed;
  for (int component = 0; component < scene.dimension(); ++component)
    engine.clip(component, prescribed);
  return compare_with_request(scene, std::move(prescribed));
}

std::int64_t make_feasible(const Scene& scene, const LinkLimits& limits,
                           const std::vector<Prescribed>& prescribed, Displacement& state, int threads) {
  const bool is_small = scene.specimen.grid.n_nodes() < nodes_worth_tiles;
  std::int64_t bytes = 0;
  if (is_homogeneous_box(scene, limits)) {
    project(scene, limits, state, threads);
    bytes = scene.specimen.grid.n_nodes() * std::int64_t{sizeof(double)};
    bytes = std::max(bytes, clamp_box(scene, limits, prescribed, state, threads));
  } else if (is_small) {
    project(scene, limits, state, threads);
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

namespace {

template<class T>
Closure<T> closure_of(const Field<T>& field, const StepBounds& bounds, bool is_least_above) {
  const Slopes slopes(bounds, is_least_above ? Side::least : Side::greatest);
  Closure<T> closure;
  closure.field = field;
  closure.is_least_above = is_least_above;
  std::ranges::copy(field.nodes, closure.nodes);
  std::ranges::copy(slopes.ahead, closure.ahead);
  std::ranges::copy(slopes.behind, closure.behind);
  return closure;
}

void raise_to(std::atomic<double>& largest, double value) {
  double known = largest.load();
  while (value > known && !largest.compare_exchange_weak(known, value)) {
  }
}

/// One component of a box; `scratch` is as large as the field. @return the largest change
template<class T>
double project_box(const Field<T>& field, T* scratch, const StepBounds& bounds, ThreadTeam& team) {
  Field<T> copy = field;
  copy.data = scratch;
  const Closure<T> above = closure_of(copy, bounds, true), below = closure_of(field, bounds, false);
  team.run(field.nodes[2], [&](int z, int) {
    std::copy_n(field.row(0, z), field.slab_stride, copy.row(0, z));
    close_slab(above, z);
    close_slab(below, z);
  });
  std::atomic<double> largest{0};
  team.run(field.nodes[1], [&](int y, int) {
    close_along_z(above, y);
    close_along_z(below, y);
    raise_to(largest, take_mean(field, copy, below.nodes, y));
    for (int z = 0; z < field.nodes[2]; ++z) { // as if the body went on
      T* const row = field.row(y, z);
      std::fill(row + field.nodes[0], row + field.row_stride, row[field.nodes[0] - 1]);
    }
  });
  return 0.5 * largest;
}

int useful_threads(const Grid& grid, int threads) {
  return grid.n_nodes() < nodes_worth_a_thread ? 1 : std::max(1, threads);
}

/// Mean of the two envelopes that all nodes of the body span.
double project_by_paths(const Scene& scene, const LinkLimits& limits, int component,
                        std::vector<double>& values) {
  const Specimen& body = scene.specimen;
  std::vector<PathEnd> ends;
  for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node)
    if (body.is_node(body.grid.node_at(node)))
      ends.push_back({node, values[static_cast<std::size_t>(node)]});
  const std::vector<double> below = upper_envelope(scene, limits, component, ends);
  const std::vector<double> above = lower_envelope(scene, limits, component, ends);
  double largest = 0;
  for (const PathEnd& end : ends) {
    const auto i = static_cast<std::size_t>(end.node);
    values[i] = 0.5 * above[i] + 0.5 * below[i]; // no overflow for values near the largest
    largest = std::max(largest, std::abs(values[i] - end.potential));
  }
  return largest;
}

} // namespace

double project(const Scene& scene, const LinkLimits& limits, Displacement& state, int threads) {
  const Grid& grid = scene.specimen.grid;
  double largest = 0;
  if (is_homogeneous_box(scene, limits)) {
    ThreadTeam team(useful_threads(grid, threads));
    const auto bounds = step_bounds(scene, limits);
    AlignedArray<double> scratch(static_cast<std::size_t>(grid.n_nodes()));
    for (std::size_t b = 0; b < state.component.size(); ++b)
      largest = std::max(largest, project_box(dense_field(grid, state.component[b].data()), scratch.data(),
                                              bounds[b], team));
  } else if (grid.n_nodes() < nodes_worth_tiles) {
    for (std::size_t b = 0; b < state.component.size(); ++b)
      largest = std::max(largest, project_by_paths(scene, limits, static_cast<int>(b), state.component[b]));
  } else {
    TiledBody body(scene, limits);
    largest = body.set_state(state);
    body.copy_to(state);
  }
  return largest;
}

double project(Body& body, const LinkLimits& limits, int threads) {
  const Scene& scene = body.scene();
  if (!is_homogeneous_box(scene, limits)) {
    Displacement state = body.displacement();
    const double largest = project(scene, limits, state, threads);
    body.set_displacement(state);
    return largest;
  }
  ThreadTeam team(useful_threads(body.grid(), threads));
  const auto bounds = step_bounds(scene, limits);
  const Field<float> first = body.field(0);
  AlignedArray<float> scratch(static_cast<std::size_t>(first.slab_stride * first.nodes[2]));
  double largest = 0;
  for (int b = 0; b < body.dimension(); ++b)
    largest = std::max(largest,
                       project_box(body.field(b), scratch.data(), bounds[static_cast<std::size_t>(b)], team));
  return largest;
}

} // namespace maille::deform
