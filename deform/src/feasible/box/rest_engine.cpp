#include "feasible/box/rest_engine.hpp"

#include "feasible/bounds/algorithm_sizes.hpp"

#include <algorithm>
#include <cmath>

namespace maille::deform {

namespace {

/// Nodes that stay at 0 need no bound: the clipped values of the others allow it.
bool is_handle(const Prescribed& p, int component) {
  return p.component == component && p.value != 0;
}

std::size_t n_handles(const std::vector<Prescribed>& prescribed, int component) {
  return static_cast<std::size_t>(
      std::ranges::count_if(prescribed, [&](const Prescribed& p) { return is_handle(p, component); }));
}

/// Steps capped by the largest displacement difference of an answer: wider links never bind, and adding their
/// slack would cost digits.
std::array<LinkIntervals<double>, 3> no_wider_than_asked(std::array<LinkIntervals<double>, 3> steps,
                                                         const std::vector<Prescribed>& prescribed) {
  Vec3 largest{};
  for (const Prescribed& p : prescribed) {
    double& here = largest[p.component];
    here = std::max(here, std::abs(p.value));
  }
  for (std::size_t b = 0; b < 3; ++b)
    for (std::size_t a = 0; a < 3 && largest[b] > 0; ++a) {
      steps[b].low[a] = std::max(steps[b].low[a], -4 * largest[b]);
      steps[b].high[a] = std::min(steps[b].high[a], 4 * largest[b]);
    }
  return steps;
}

} // namespace

RestEngine::RestEngine(const Scene& scene, const LinkLimits& limits, const Plan& plan, int threads)
    : scene_(scene), algorithm_(plan.of_component),
      steps_(no_wider_than_asked(intervals_by_axis(scene, limits), scene.prescribed)),
      team_(useful_threads(scene.specimen.grid.n_nodes(), threads)), bounds_(scene.specimen.grid, steps_),
      clipper_(bounds_, scene.specimen.grid), closed_form_(scene.specimen.grid),
      scans_(scene.specimen.grid, steps_, team_.threads()) {}

std::int64_t RestEngine::drag(int component, const std::vector<Prescribed>& prescribed, Displacement& state) {
  const auto b = static_cast<std::size_t>(component);
  const Grid& grid = scene_.specimen.grid;
  handles_.clear();
  handles_.reserve(n_handles(prescribed, component));
  for (const Prescribed& p : prescribed)
    if (is_handle(p, component))
      handles_.push_back({grid.node_at(p.node), p.value});
  std::ranges::sort(handles_, {}, [&](const HandleValue& h) { return grid.node(h.at); });
  const Field<double> field = dense_field(grid, state.component(b).data());
  Rounding rounding;
  std::int64_t visited = 0;
  if (algorithm_[b] == Algorithm::separable_scans) {
    scans_.add(component, field, handles_, rounding);
    visited = scans_.run(team_);
  } else {
    for (const HandleValue& handle : handles_) {
      closed_form_.add(component, field, steps_[b], handle.at, handle.value, rounding);
      visited += closed_form_.run(team_);
    }
  }
  if (!handles_.empty())
    for (const Prescribed& p :
         prescribed) // sums along paths may have moved it by rounding, what is held no less
      if (p.component == component)
        field.at(grid.node_at(p.node)) = p.value;
  return visited;
}

} // namespace maille::deform
