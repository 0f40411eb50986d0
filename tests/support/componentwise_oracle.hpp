#pragma once
/// Reference implementation of the componentwise model: dense matrices, pointwise Gauss-Seidel, Hildreth's
/// dual method.

#include "maille/scene/link_limits.hpp"

#include <Eigen/Dense>
#include <algorithm>
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

/// Problem of one component on the nodes connected to prescribed ones by links.
struct DenseProblem {
  std::vector<WeightedLink> links;
  std::vector<std::int64_t> free;   ///< grid nodes
  std::vector<double> fixed_values; ///< per grid node; NaN for free or loose nodes
  Eigen::MatrixXd A;                ///< matrix of the free nodes
  Eigen::VectorXd b;
};

inline DenseProblem dense_problem(const Scene& scene, const std::vector<Prescribed>& prescribed,
                                  int component, const List<double>& forces = {}) {
  DenseProblem problem;
  problem.links = weighted_links(scene, LinkLimits(scene), component);
  const auto n = static_cast<std::size_t>(scene.specimen.grid.n_nodes());
  problem.fixed_values.assign(n, std::nan(""));
  std::vector<bool> reached(n, false);
  for (const Prescribed& p : prescribed)
    if (p.component == component) {
      problem.fixed_values[static_cast<std::size_t>(p.node)] = p.value;
      reached[static_cast<std::size_t>(p.node)] = true;
    }
  for (bool grows = true; grows;) {
    grows = false;
    for (const WeightedLink& link : problem.links) {
      const auto i = static_cast<std::size_t>(link.near), j = static_cast<std::size_t>(link.far);
      if (reached[i] != reached[j])
        reached[i] = reached[j] = grows = true;
    }
  }
  std::vector<Eigen::Index> number(n, -1);
  for (std::size_t i = 0; i < n; ++i)
    if (reached[i] && std::isnan(problem.fixed_values[i])) {
      number[i] = static_cast<Eigen::Index>(problem.free.size());
      problem.free.push_back(static_cast<std::int64_t>(i));
    }
  const auto size = static_cast<Eigen::Index>(problem.free.size());
  problem.A = Eigen::MatrixXd::Zero(size, size);
  problem.b = Eigen::VectorXd::Zero(size);
  for (std::size_t k = 0; k < problem.free.size() && !forces.empty(); ++k)
    problem.b(static_cast<Eigen::Index>(k)) = forces[static_cast<std::size_t>(problem.free[k])];
  for (const WeightedLink& link : problem.links) {
    const auto i = static_cast<std::size_t>(link.near), j = static_cast<std::size_t>(link.far);
    for (const auto& [here, other] : {std::pair(i, j), std::pair(j, i)}) {
      if (number[here] < 0)
        continue;
      problem.A(number[here], number[here]) += link.weight;
      if (number[other] >= 0)
        problem.A(number[here], number[other]) -= link.weight;
      else
        problem.b(number[here]) += link.weight * problem.fixed_values[other];
    }
  }
  return problem;
}

/// Values per grid node; 0 for loose nodes.
inline std::vector<double> spread(const DenseProblem& problem, const Eigen::VectorXd& x) {
  std::vector<double> u;
  for (const double value : problem.fixed_values)
    u.push_back(std::isnan(value) ? 0 : value);
  for (std::size_t k = 0; k < problem.free.size(); ++k)
    u[static_cast<std::size_t>(problem.free[k])] = x(static_cast<Eigen::Index>(k));
  return u;
}

inline double energy_of(const std::vector<WeightedLink>& links, std::span<const double> u) {
  double sum = 0;
  for (const WeightedLink& link : links) {
    const double d = u[static_cast<std::size_t>(link.far)] - u[static_cast<std::size_t>(link.near)];
    sum += 0.5 * link.weight * d * d;
  }
  return sum;
}

/// Gauss-Seidel, node by node: `sweep`'s rule with weights. Ends when no node moves.
inline std::vector<double> weighted_sweeps(const DenseProblem& problem, int sweeps) {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(problem.b.size());
  for (int sweep = 0; sweep < sweeps; ++sweep)
    for (Eigen::Index i = 0; i < x.size(); ++i)
      x(i) += (problem.b(i) - problem.A.row(i).dot(x)) / problem.A(i, i);
  return spread(problem, x);
}

/// Constrained minimum within the limits, by coordinate ascent on the multipliers (Hildreth 1957). @param
/// broken receives the largest violation of a limit, which measures convergence: multipliers are feasible
/// throughout, so an answer without violation is the optimum
inline std::vector<double> constrained_minimum(const DenseProblem& problem, double& broken) {
  const Eigen::Index n = problem.b.size();
  std::vector<Eigen::Index> number(problem.fixed_values.size(), -1);
  for (Eigen::Index k = 0; k < n; ++k)
    number[static_cast<std::size_t>(problem.free[static_cast<std::size_t>(k)])] = k;
  // Rows of `D`: differences along links with a free end; offset: contribution of fixed ends.
  std::vector<Eigen::VectorXd> rows;
  std::vector<double> low, high;
  for (const WeightedLink& link : problem.links) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(n);
    double offset = 0;
    for (const auto& [node, sign] : {std::pair(link.near, -1.0), std::pair(link.far, 1.0)}) {
      const auto i = static_cast<std::size_t>(node);
      if (number[i] >= 0)
        row(number[i]) += sign;
      else if (!std::isnan(problem.fixed_values[i]))
        offset += sign * problem.fixed_values[i];
    }
    if (row.isZero())
      continue;
    rows.push_back(row);
    low.push_back(link.low - offset);
    high.push_back(link.high - offset);
  }
  const auto m = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd D(m, n);
  for (Eigen::Index k = 0; k < m; ++k)
    D.row(k) = rows[static_cast<std::size_t>(k)];
  const Eigen::LLT<Eigen::MatrixXd> factor(problem.A);
  const Eigen::MatrixXd AinvDt = factor.solve(D.transpose());
  const Eigen::MatrixXd H = D * AinvDt;
  Eigen::VectorXd x = factor.solve(problem.b);
  Eigen::VectorXd d = D * x, lambda = Eigen::VectorXd::Zero(m);
  for (int round = 0; round < 20000; ++round) {
    broken = 0;
    for (Eigen::Index k = 0; k < m; ++k) {
      const auto i = static_cast<std::size_t>(k);
      broken = std::max({broken, low[i] - d(k), d(k) - high[i]});
      // The multiplier of low <= d is -min(lambda, 0), that of d <= high max(lambda, 0).
      const double free_value = d(k) + H(k, k) * lambda(k);
      const double next = free_value > high[i]  ? (free_value - high[i]) / H(k, k)
                          : free_value < low[i] ? (free_value - low[i]) / H(k, k)
                                                : 0;
      d -= H.col(k) * (next - lambda(k));
      lambda(k) = next;
    }
    if (broken < 1e-13)
      break;
  }
  return spread(problem, x - AinvDt * lambda);
}

} // namespace maille::test
