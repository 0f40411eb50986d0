#pragma once
/// Dense quadratic programs over displacements: the reference for elastic answers within limits of links.

#include "maille/scene/answer.hpp"
#include "support/fields.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace maille::test {

/// Least 1/2 u . K u - force . u over the unknowns, with low <= rows . u <= high.
struct QuadraticProgram {
  /// A factor of a component of a node in a row.
  struct Entry {
    double factor;
    std::size_t component;
    std::int64_t node;
  };

  Displacement values;                                        ///< of all that is no unknown
  std::vector<std::pair<std::size_t, std::int64_t>> unknowns; ///< component, node
  Eigen::MatrixXd K;
  Eigen::VectorXd force;

  QuadraticProgram(Displacement of_others, std::vector<std::pair<std::size_t, std::int64_t>> of_unknowns)
      : values(std::move(of_others)), unknowns(std::move(of_unknowns)), number_(values.values().size(), -1) {
    for (const auto& [b, node] : unknowns)
      number_[place(b, node)] = n_++;
    K = Eigen::MatrixXd::Zero(n_, n_);
    force = Eigen::VectorXd::Zero(n_);
  }
  /// 1/2 weight (u_i - u_j)^2 of one component.
  void add_spring(std::size_t b, std::int64_t i, std::int64_t j, double weight) {
    for (const auto& [here, other] : {std::pair(i, j), std::pair(j, i)}) {
      const Eigen::Index at = number_[place(b, here)], beyond = number_[place(b, other)];
      if (at < 0)
        continue;
      K(at, at) += weight;
      if (beyond >= 0)
        K(at, beyond) -= weight;
      else
        force(at) += weight * values(b, other);
    }
  }
  /// @param low, high  equal for an equation, infinite without a bound. Rows without unknowns are left out.
  void add_row(const std::vector<Entry>& entries, double low, double high) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(n_);
    double offset = 0;
    for (const auto& [factor, b, node] : entries)
      if (const Eigen::Index at = number_[place(b, node)]; at >= 0)
        row(at) += factor;
      else
        offset += factor * values(b, node);
    if (row.isZero())
      return;
    rows_.push_back(row);
    low_.push_back(low - offset);
    high_.push_back(high - offset);
  }
  Displacement spread(const Eigen::VectorXd& x) const {
    Displacement u = values;
    for (Eigen::Index i = 0; i < n_; ++i)
      u(unknowns[std::size_t(i)].first, unknowns[std::size_t(i)].second) = x(i);
    return u;
  }
  /// The least without rows.
  Displacement elastic() const { return spread(K.llt().solve(force)); }
  /// Coordinate ascent on the multipliers. @return whether none changes the state by more than 1e-9 of it
  /// Source  Hildreth 1957, Naval Research Logistics Quarterly 4
  bool solve(Displacement& u) const {
    const auto m = Eigen::Index(rows_.size());
    Eigen::MatrixXd D(m, n_);
    for (Eigen::Index l = 0; l < m; ++l)
      D.row(l) = rows_[std::size_t(l)];
    const Eigen::LLT<Eigen::MatrixXd> factors(K);
    const Eigen::VectorXd free = factors.solve(force);
    const Eigen::MatrixXd response = factors.solve(D.transpose()), G = D * response;
    Eigen::VectorXd difference = D * free, multiplier = Eigen::VectorXd::Zero(m);
    const double size = largest(spread(free));
    double change = size;
    for (int sweep = 0; sweep < 200000 && change > 1e-13 * size; ++sweep) {
      change = 0;
      for (Eigen::Index l = 0; l < m; ++l) {
        const double alone = difference(l) + G(l, l) * multiplier(l);
        const double kept = std::clamp(alone, low_[std::size_t(l)], high_[std::size_t(l)]);
        const double step = (alone - kept) / G(l, l) - multiplier(l);
        multiplier(l) += step;
        if (step != 0)
          difference -= step * G.col(l);
        change = std::max(change, std::abs(step) * G(l, l));
      }
    }
    u = spread(free - response * multiplier);
    return change <= 1e-9 * size;
  }

private:
  std::size_t place(std::size_t b, std::int64_t node) const {
    return b * values.n_nodes() + std::size_t(node);
  }

  Eigen::Index n_ = 0;
  std::vector<Eigen::Index> number_; ///< of unknowns, by component and node; -1 for others
  std::vector<Eigen::VectorXd> rows_;
  std::vector<double> low_, high_;
};

/// Components of nodes of the body that are not prescribed; the values of those that are.
inline QuadraticProgram program_of(const Scene& scene, const std::vector<Prescribed>& prescribed) {
  const Grid& grid = scene.specimen.grid;
  Displacement values(grid), is_prescribed(grid);
  for (const Prescribed& p : prescribed) {
    values(p.component, p.node) = p.value;
    is_prescribed(p.component, p.node) = 1;
  }
  std::vector<std::pair<std::size_t, std::int64_t>> unknowns;
  for (std::size_t b = 0; b < values.n_components(); ++b)
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
      if (is_prescribed(b, node) == 0 && scene.specimen.is_node(grid.node_at(node)))
        unknowns.emplace_back(b, node);
  return {std::move(values), std::move(unknowns)};
}

} // namespace maille::test
