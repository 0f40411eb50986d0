#pragma once
/// Minimum elastic energy of a small body within the limits of its links, by dense matrices.

#include "elastic/model/lattice_elasticity.hpp"
#include "maille/scene/answer.hpp"
#include "support/fields.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace maille::test {

using deform::LatticeElasticity;
using deform::ThreadTeam;

/// 1/2 u . K u with prescribed components, subject to limits of links, dense.
struct DenseProgram {
  Displacement start;
  std::vector<std::pair<std::size_t, std::size_t>> unknowns; ///< component, node
  Eigen::MatrixXd K, D;                                      ///< of the unknowns
  Eigen::VectorXd force, offset, low, high;                  ///< low <= D u + offset <= high

  DenseProgram(const Scene& scene, const std::vector<Prescribed>& prescribed);
  /// Hildreth 1957: optimises one multiplier after the other. @return false without convergence
  bool solve(Displacement& u) const;
};

inline DenseProgram::DenseProgram(const Scene& scene, const std::vector<Prescribed>& prescribed)
    : start(scene.specimen.grid) {
  const Grid& grid = scene.specimen.grid;
  const auto d = static_cast<std::size_t>(scene.dimension());
  std::vector<std::vector<Eigen::Index>> place(d, std::vector<Eigen::Index>(std::size_t(grid.n_nodes()), -1));
  for (const Prescribed& p : prescribed) {
    start(p.component, p.node) = p.value;
    place[std::size_t(p.component)][std::size_t(p.node)] = -2;
  }
  for (std::size_t b = 0; b < d; ++b)
    for (std::size_t i = 0; i < place[b].size(); ++i)
      if (place[b][i] == -1 && scene.specimen.is_node(grid.node_at(std::int64_t(i)))) {
        place[b][i] = Eigen::Index(unknowns.size());
        unknowns.emplace_back(b, i);
      }
  const auto n = Eigen::Index(unknowns.size());
  ThreadTeam team(1);
  const LatticeElasticity elasticity(scene);
  Displacement unit(grid), forces(grid);
  const auto column = [&](const Displacement& u) {
    elasticity.apply(u, forces, team);
    Eigen::VectorXd values(n);
    for (Eigen::Index i = 0; i < n; ++i)
      values[i] = forces(unknowns[std::size_t(i)].first, unknowns[std::size_t(i)].second);
    return values;
  };
  force = -column(start);
  K.resize(n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    double& value = unit(unknowns[std::size_t(j)].first, unknowns[std::size_t(j)].second);
    value = 1;
    K.col(j) = column(unit);
    value = 0;
  }
  const LinkLimits limits(scene);
  std::vector<std::array<double, 3>> numbers; // low, high, offset
  std::vector<Eigen::RowVectorXd> rows;
  for (std::size_t b = 0; b < d; ++b)
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
      for (int axis = 0; axis < grid.dimension(); ++axis) {
        const auto interval = limits.intervals(grid.node_at(node), axis);
        const auto near = std::size_t(node), far = near + std::size_t(grid.stride(axis));
        if (!interval || (place[b][near] < 0 && place[b][far] < 0))
          continue;
        Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(n);
        if (place[b][near] >= 0)
          row[place[b][near]] = -1;
        if (place[b][far] >= 0)
          row[place[b][far]] = 1;
        rows.push_back(row);
        numbers.push_back({interval->low[b], interval->high[b], start(b, far) - start(b, near)});
      }
  const auto m = Eigen::Index(rows.size());
  D.resize(m, n);
  low.resize(m), high.resize(m), offset.resize(m);
  for (Eigen::Index l = 0; l < m; ++l) {
    D.row(l) = rows[std::size_t(l)];
    low[l] = numbers[std::size_t(l)][0], high[l] = numbers[std::size_t(l)][1];
    offset[l] = numbers[std::size_t(l)][2];
  }
}

inline bool DenseProgram::solve(Displacement& u) const {
  const Eigen::LLT<Eigen::MatrixXd> factors(K);
  const Eigen::VectorXd free = factors.solve(force);
  const Eigen::MatrixXd response = factors.solve(D.transpose()), G = D * response;
  Eigen::VectorXd difference = D * free + offset, multiplier = Eigen::VectorXd::Zero(D.rows());
  double change = 1;
  for (int sweep = 0; sweep < 40000 && change > 1e-12 * high.maxCoeff(); ++sweep) {
    change = 0;
    for (Eigen::Index l = 0; l < D.rows(); ++l) {
      const double alone = difference[l] + G(l, l) * multiplier[l];
      const double outside = alone - std::clamp(alone, low[l], high[l]),
                   step = outside / G(l, l) - multiplier[l];
      if (step == 0)
        continue;
      multiplier[l] += step;
      difference -= step * G.col(l);
      change = std::max(change, std::abs(step) * G(l, l));
    }
  }
  const Eigen::VectorXd best = free - response * multiplier;
  u = start;
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    u(unknowns[i].first, unknowns[i].second) = best[Eigen::Index(i)];
  return change <= 1e-9 * high.maxCoeff();
}

/// 1/2 u . K u [J].
inline double elastic_energy(const Scene& scene, const Displacement& u) {
  ThreadTeam team(1);
  Displacement forces(scene.specimen.grid);
  LatticeElasticity(scene).apply(u, forces, team);
  return 0.5 * test::product(u, forces);
}

} // namespace maille::test
