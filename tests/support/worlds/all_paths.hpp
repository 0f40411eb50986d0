#pragma once
/// Reference implementation of shortest paths, envelopes and clipping: all pairs of nodes, without a queue.

#include "maille/scene/answer.hpp"

#include <algorithm>
#include <limits>

namespace maille::test {

/// d(i, j) between all grid nodes for one component, by Floyd 1962.
class AllPaths {
public:
  AllPaths(const Scene& scene, const LinkLimits& limits, int component)
      : n_(std::size_t(scene.specimen.grid.n_nodes())), d_(n_ * n_, std::numeric_limits<double>::infinity()) {
    const Grid& grid = scene.specimen.grid;
    const auto b = std::size_t(component);
    for (std::size_t i = 0; i < n_; ++i) {
      d_[i * n_ + i] = 0;
      const Index3 at = grid.node_at(std::int64_t(i));
      for (int axis = 0; axis < grid.dimension(); ++axis) {
        const auto a = std::size_t(axis);
        if (at[a] + 1 >= grid.nodes()[a])
          continue;
        const auto link = limits.intervals(at, axis);
        if (!link)
          continue;
        const std::size_t j = i + std::size_t(grid.stride(axis));
        d_[i * n_ + j] = link->high[b];
        d_[j * n_ + i] = -link->low[b];
      }
    }
    for (std::size_t k = 0; k < n_; ++k)
      for (std::size_t i = 0; i < n_; ++i)
        for (std::size_t j = 0; j < n_; ++j)
          d_[i * n_ + j] = std::min(d_[i * n_ + j], d_[i * n_ + k] + d_[k * n_ + j]);
  }
  double operator()(std::int64_t from, std::int64_t to) const {
    return d_[std::size_t(from) * n_ + std::size_t(to)];
  }
  double highest(const std::vector<Prescribed>& ends, std::int64_t i) const {
    double bound = std::numeric_limits<double>::infinity();
    for (const Prescribed& h : ends)
      bound = std::min(bound, h.value + (*this)(h.node, i));
    return bound;
  }
  double lowest(const std::vector<Prescribed>& ends, std::int64_t i) const {
    double bound = -std::numeric_limits<double>::infinity();
    for (const Prescribed& h : ends)
      bound = std::max(bound, h.value - (*this)(i, h.node));
    return bound;
  }
  /// Largest p_h - p_g - d(g, h) over all pairs: > 0 for incompatible values.
  double worst_contradiction(const std::vector<Prescribed>& ends) const {
    double worst = -std::numeric_limits<double>::infinity();
    for (const Prescribed& g : ends)
      for (const Prescribed& h : ends)
        if (g.node != h.node)
          worst = std::max(worst, h.value - g.value - (*this)(g.node, h.node));
    return worst;
  }

private:
  std::size_t n_;
  std::vector<double> d_;
};

} // namespace maille::test
