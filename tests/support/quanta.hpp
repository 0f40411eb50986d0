#pragma once
/// Oracle of the wavefront, exact to the bit: the same integers by Dijkstra.

#include "feasible/wavefront/wavefront.hpp"
#include "rivals/rivals.hpp"

#include <algorithm>
#include <cmath>

namespace maille::test {

/// State of a body in integer quanta, moved by Dijkstra on flat arrays.
class StateByDijkstra {
public:
  StateByDijkstra(const Scene& scene, const LinkLimits& limits, const deform::TiledBody& body)
      : scene_(&scene), limits_(&limits) {
    for (int b = 0; b < scene.dimension(); ++b) {
      quantum_.push_back(body.quantum(b));
      values_.emplace_back(static_cast<std::size_t>(scene.specimen.grid.n_nodes()), 0);
    }
  }

  /// min(max(x, L), U) for clipped values. @param body after the same move: for its quanta
  void move(const deform::TiledBody& body, const std::vector<Prescribed>& clipped) {
    for (int b = 0; b < scene_->dimension(); ++b)
      move(b, body.quantum(b), clipped);
  }

  /// Displacement in the form of TiledBody::copy_to.
  Displacement displacement(const std::vector<Prescribed>& prescribed) const {
    Displacement u(scene_->specimen.grid);
    for (std::size_t b = 0; b < values_.size(); ++b)
      for (std::size_t i = 0; i < values_[b].size(); ++i)
        u(b, i) = static_cast<double>(values_[b][i]) * quantum_[b];
    for (const Prescribed& p : prescribed)
      u(p.component, p.node) = p.value;
    return u;
  }

private:
  void move(int component, double quantum, const std::vector<Prescribed>& clipped) {
    const auto b = static_cast<std::size_t>(component);
    std::vector<std::int64_t>& state = values_[b];
    for (; quantum_[b] < quantum; quantum_[b] *= 2) // coarser quanta: rounded down
      for (std::int64_t& value : state)
        value >>= 1;
    std::vector<std::pair<std::int64_t, std::int64_t>> ends; // node, value
    for (const Prescribed& p : clipped)
      if (p.component == component)
        ends.emplace_back(p.node, static_cast<std::int64_t>(std::floor(p.value / quantum)));
    if (ends.empty())
      return;
    std::int64_t low = ends.front().second, high = low;
    for (const auto& [node, value] : ends) {
      low = std::min(low, value);
      high = std::max(high, value);
    }
    const auto [least, most] = std::ranges::minmax(state);
    if (std::max(most, high) - std::min(least, low) <= 1 << 30) {
      low = std::min(least, low);
      high = std::max(most, high);
    }
    const std::int64_t middle = low + (high - low) / 2;
    const auto stored = [&](std::int64_t value) { // saturates far values, which have no effect
      return static_cast<std::int32_t>(std::clamp<std::int64_t>(value - middle, -(1 << 29), 1 << 29));
    };
    std::vector<std::int32_t> x(state.size());
    std::ranges::transform(state, x.begin(), stored);
    const std::vector<std::int32_t> before = x;
    const lab::FlatLinks links(*scene_, *limits_, component, quantum);
    std::vector<lab::FlatSeed> up, down;
    for (const auto& [node, value] : ends) {
      up.push_back({node, stored(value)});
      down.push_back({node, -stored(value)});
    }
    lab::dijkstra_flat(links.drop, links.stride, x, up);
    for (auto& value : x)
      value = -value;
    lab::dijkstra_flat(links.climb, links.stride, x, down);
    for (std::size_t i = 0; i < x.size(); ++i)
      if (-x[i] != before[i])
        state[i] = middle - x[i];
  }

  const Scene* scene_;
  const LinkLimits* limits_;
  std::vector<double> quantum_;
  std::vector<std::vector<std::int64_t>> values_;
};

/// Largest violation of a link limit, in units of `unit` [m].
inline double worst_violation(const Scene& scene, const LinkLimits& limits, const Displacement& u,
                              double unit) {
  const Grid& grid = scene.specimen.grid;
  double worst = 0;
  for (std::int64_t n = 0; n < grid.n_nodes(); ++n)
    for (int axis = 0; axis < grid.dimension(); ++axis) {
      const Index3 at = grid.node_at(n);
      if (at[static_cast<std::size_t>(axis)] + 1 >= grid.nodes()[static_cast<std::size_t>(axis)])
        continue;
      const auto link = limits.intervals(at, axis);
      for (int b = 0; link && b < grid.dimension(); ++b) {
        const double d = u(b, n + grid.stride(axis)) - u(b, n);
        const auto c = static_cast<std::size_t>(b);
        worst = std::max({worst, (link->low[c] - d) / unit, (d - link->high[c]) / unit});
      }
    }
  return worst;
}

/// Upper bound of the links in a shortest path: it visits no node twice.
inline double longest_path(const Scene& scene) {
  return static_cast<double>(scene.specimen.n_matter_nodes());
}

} // namespace maille::test
