#include "feasible/projection.hpp"

#include "feasible/bounds/algorithm_sizes.hpp"
#include "feasible/bounds/bound_source.hpp"
#include "feasible/box/rest_engine.hpp"
#include "feasible/feasible_set.hpp"
#include "feasible/limits.hpp"
#include "feasible/wavefront/wavefront.hpp"
#include "parallel/thread_team.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

namespace maille::deform {

namespace {

Closure closure_of(const Field<double>& field, const LinkIntervals<double>& bounds, bool is_least_above) {
  const Slopes slopes(bounds, is_least_above ? Side::least : Side::greatest);
  Closure closure;
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
double project_box(const Field<double>& field, double* scratch, const LinkIntervals<double>& bounds,
                   ThreadTeam& team) {
  Field<double> copy = field;
  copy.data = scratch;
  const Closure above = closure_of(copy, bounds, true), below = closure_of(field, bounds, false);
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
      double* const row = field.row(y, z);
      std::fill(row + field.nodes[0], row + field.row_stride, row[field.nodes[0] - 1]);
    }
  });
  return 0.5 * largest;
}

/// Mean of the two envelopes that all nodes of the body span.
double project_by_paths(const Scene& scene, const LinkLimits& limits, int component,
                        std::span<double> values) {
  const Specimen& body = scene.specimen;
  List<PathEnd> ends;
  for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node)
    if (body.is_node(body.grid.node_at(node)))
      ends.push_back({node, values[node]});
  const List<double> below = upper_envelope(scene, limits, component, ends);
  const List<double> above = lower_envelope(scene, limits, component, ends);
  double largest = 0;
  for (const PathEnd& end : ends) {
    const auto i = static_cast<std::size_t>(end.node);
    values[i] = 0.5 * above[i] + 0.5 * below[i]; // no overflow for values near the largest
    largest = std::max(largest, std::abs(values[i] - end.potential));
  }
  return largest;
}

} // namespace

double FeasibleSet::project(Displacement& state) const {
  const Grid& grid = scene_.specimen.grid;
  double largest = 0;
  if (is_homogeneous_box()) {
    ThreadTeam team(useful_threads(grid.n_nodes(), threads_));
    const auto bounds = intervals_by_axis(scene_, limits_);
    AlignedArray<double> scratch(static_cast<std::size_t>(grid.n_nodes()));
    for (std::size_t b = 0; b < state.n_components(); ++b)
      largest = std::max(largest, project_box(dense_field(grid, state.component(b).data()), scratch.data(),
                                              bounds[b], team));
  } else if (is_small()) {
    for (std::size_t b = 0; b < state.n_components(); ++b)
      largest = std::max(largest, project_by_paths(scene_, limits_, static_cast<int>(b), state.component(b)));
  } else {
    TiledBody body(scene_, limits_);
    largest = body.set_state(state);
    body.copy_to(state);
  }
  return largest;
}

void FeasibleSet::clamp_box(const std::vector<Prescribed>& clipped, Displacement& state) const {
  const Grid& grid = scene_.specimen.grid;
  ThreadTeam team(useful_threads(grid.n_nodes(), threads_));
  SeparableScans<double> scans(grid, intervals_by_axis(scene_, limits_), team.threads());
  std::vector<HandleValue> handles;
  Rounding rounding;
  for (int component = 0; component < scene_.dimension(); ++component) {
    handles.clear();
    for (const Prescribed& p : clipped)
      if (p.component == component && state(component, p.node) != p.value)
        handles.push_back({grid.node_at(p.node), p.value});
    const std::span<double> u = state.component(component);
    for (const double value : u)
      rounding.largest = std::max(rounding.largest, std::abs(value));
    scans.add(component, dense_field(grid, u.data()), handles, rounding);
  }
  scans.run(team);
}

void FeasibleSet::bring_in(const std::vector<Prescribed>& clipped, Displacement& state) const {
  if (is_homogeneous_box()) {
    project(state);
    clamp_box(clipped, state);
  } else if (is_small()) {
    project(state);
    propagate(scene_, limits_, clipped, state);
  } else {
    TiledBody body(scene_, limits_);
    body.set_state(state);
    body.move(clipped, threads_);
    body.copy_to(state);
  }
  for (const Prescribed& p : clipped) // to the last bit
    state(p.component, p.node) = p.value;
}

} // namespace maille::deform
