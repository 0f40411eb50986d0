#pragma once
/// Reference implementation of the componentwise model by dense matrices.

#include "maille/scene/link_limits.hpp"
#include "support/quadratic_program.hpp"

#include <cmath>
#include <span>
#include <vector>

namespace maille::test {

/// A link of one component: 1/2 weight (u_far - u_near)^2, low <= u_far - u_near <= high.
struct WeightedLink {
  std::int64_t near = 0, far = 0;
  double weight = 0, low = 0, high = 0;
};

/// Assembled link by link from the cells around it: V / 2^(d-1) modulus / h_a^2 each, the modulus C_bb for
/// a = b and the shear modulus else.
inline std::vector<WeightedLink> weighted_links(const Scene& scene, const LinkLimits& limits, int component) {
  const Grid& grid = scene.specimen.grid;
  const int d = scene.dimension();
  double volume = 1;
  for (int a = 0; a < d; ++a)
    volume *= grid.spacing()[static_cast<std::size_t>(a)];
  std::vector<WeightedLink> links;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
    for (int axis = 0; axis < d; ++axis) {
      const Index3 at = grid.node_at(node);
      const auto a = static_cast<std::size_t>(axis);
      if (at[a] + 1 >= grid.nodes()[a])
        continue;
      WeightedLink link{node, node + grid.stride(axis), 0, 0, 0};
      scene.specimen.for_each_cell_at_link(at, axis, [&](std::int64_t cell) {
        const Eigen::MatrixXd C = scene.cell_stiffness(cell);
        int row = axis; // Voigt 11 22 33 23 13 12, or 11 22 12
        if (axis != component)
          row = d == 2 ? 2 : 6 - axis - component;
        link.weight += volume / (1 << (d - 1)) * C(row, row) / (grid.spacing()[a] * grid.spacing()[a]);
      });
      if (link.weight == 0)
        continue;
      const auto interval = limits.intervals(at, axis);
      link.low = interval->low[static_cast<std::size_t>(component)];
      link.high = interval->high[static_cast<std::size_t>(component)];
      links.push_back(link);
    }
  return links;
}

/// Program of one component on the nodes connected to prescribed ones by links; loose nodes stay at 0.
inline QuadraticProgram dense_problem(const Scene& scene, const std::vector<Prescribed>& prescribed,
                                      int component, const List<double>& forces = {}) {
  const auto links = weighted_links(scene, LinkLimits(scene), component);
  Displacement values(scene.specimen.grid);
  std::vector<bool> is_fixed(values.n_nodes(), false);
  for (const Prescribed& p : prescribed)
    if (p.component == component) {
      values(component, p.node) = p.value;
      is_fixed[static_cast<std::size_t>(p.node)] = true;
    }
  std::vector<bool> reached = is_fixed;
  for (bool grows = true; grows;) {
    grows = false;
    for (const WeightedLink& link : links) {
      const auto i = static_cast<std::size_t>(link.near), j = static_cast<std::size_t>(link.far);
      if (reached[i] != reached[j])
        reached[i] = reached[j] = grows = true;
    }
  }
  std::vector<std::pair<std::size_t, std::int64_t>> unknowns;
  const auto b = static_cast<std::size_t>(component);
  for (std::size_t i = 0; i < reached.size(); ++i)
    if (reached[i] && !is_fixed[i])
      unknowns.emplace_back(b, i);
  QuadraticProgram program(std::move(values), std::move(unknowns));
  for (std::size_t k = 0; k < program.unknowns.size() && !forces.empty(); ++k)
    program.force(static_cast<Eigen::Index>(k)) =
        forces[static_cast<std::size_t>(program.unknowns[k].second)];
  for (const WeightedLink& link : links) {
    program.add_spring(b, link.near, link.far, link.weight);
    program.add_row({{1, b, link.far}, {-1, b, link.near}}, link.low, link.high);
  }
  return program;
}

inline double energy_of(const std::vector<WeightedLink>& links, std::span<const double> u) {
  double sum = 0;
  for (const WeightedLink& link : links) {
    const double d = u[static_cast<std::size_t>(link.far)] - u[static_cast<std::size_t>(link.near)];
    sum += 0.5 * link.weight * d * d;
  }
  return sum;
}

} // namespace maille::test
