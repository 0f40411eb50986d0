#include "world/surface/contact_program.hpp"

#include "lattice/tolerances.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <vector>

namespace maille::deform {

namespace {

Eigen::VectorXd forces_of(const Eigen::MatrixXd& compliance, const Eigen::VectorXd& gap0,
                          const std::vector<char>& active) {
  std::vector<Eigen::Index> set;
  for (std::size_t i = 0; i < active.size(); ++i)
    if (active[i] != 0)
      set.push_back(static_cast<Eigen::Index>(i));
  Eigen::VectorXd force = Eigen::VectorXd::Zero(gap0.size());
  if (!set.empty()) {
    const Eigen::MatrixXd of_set = compliance(set, set);
    const Eigen::VectorXd missing = -gap0(set);
    const Eigen::LLT<Eigen::MatrixXd> factor(of_set); // LDLT if rounding makes LLT fail
    const Eigen::VectorXd found = factor.info() == Eigen::Success
                                      ? Eigen::VectorXd(factor.solve(missing))
                                      : Eigen::VectorXd(of_set.ldlt().solve(missing));
    force(set) = found;
  }
  return force;
}

/// The same by an interior-point method: for redundant contacts, where active sets alternate.
/// Source  Mehrotra 1992 (SIAM J. Optim. 2)
Eigen::VectorXd forces_by_interior_point(const Eigen::MatrixXd& compliance, const Eigen::VectorXd& gap0,
                                         const std::vector<char>& may_pull) {
  constexpr double most_of_the_way = 0.995;
  const Eigen::Index n = gap0.size();
  Eigen::ArrayXd presses(n); // 1, or 0 where a force may pull
  for (Eigen::Index i = 0; i < n; ++i)
    presses[i] = may_pull[i] == 0 ? 1 : 0;
  const double n_press = std::max(1.0, presses.sum()), length = gap0.cwiseAbs().maxCoeff();
  const double size = length / compliance.diagonal().mean(); // of a force [N]
  if (!(length > 0))
    return Eigen::VectorXd::Zero(n);
  Eigen::ArrayXd force = presses * size, gap = presses * length;
  const auto along = [&](const Eigen::ArrayXd& from, const Eigen::ArrayXd& way) {
    double part = 1;
    for (Eigen::Index i = 0; i < n; ++i)
      if (presses[i] > 0 && way[i] < 0)
        part = std::min(part, -from[i] / way[i]);
    return part;
  };
  for (int step = 0; step < iteration_cap; ++step) {
    const Eigen::ArrayXd left = (compliance * force.matrix() + gap0).array() - gap;
    const double mean = (force * gap).sum() / n_press;
    if (mean <= rounding * size * length && left.abs().maxCoeff() <= rounding * length)
      break;
    Eigen::MatrixXd matrix = compliance;
    const Eigen::ArrayXd safe = force + (1 - presses); // avoids division by 0
    matrix.diagonal().array() += presses * gap / safe;
    const Eigen::LLT<Eigen::MatrixXd> factor(matrix);
    if (factor.info() != Eigen::Success)
      break; // at rounding level
    const auto way_of_force = [&](const Eigen::ArrayXd& target) -> Eigen::ArrayXd {
      return factor.solve((-left + presses * (target / safe - gap)).matrix()).array();
    };
    const auto way_of_gap = [&](const Eigen::ArrayXd& target,
                                const Eigen::ArrayXd& of_force) -> Eigen::ArrayXd {
      return presses * ((target - gap * of_force) / safe - gap);
    };
    const Eigen::ArrayXd zero = Eigen::ArrayXd::Zero(n), force_first = way_of_force(zero),
                         gap_first = way_of_gap(zero, force_first);
    const double far = std::min(along(force, force_first), along(gap, gap_first)),
                 mean_there = ((force + far * force_first) * (gap + far * gap_first)).sum() / n_press,
                 centring = std::pow(std::max(0.0, mean_there / mean), 3);
    const Eigen::ArrayXd target = presses * (centring * mean) - force_first * gap_first;
    const Eigen::ArrayXd force_way = way_of_force(target), gap_way = way_of_gap(target, force_way);
    force += std::min(1.0, most_of_the_way * along(force, force_way)) * force_way;
    gap += std::min(1.0, most_of_the_way * along(gap, gap_way)) * gap_way;
  }
  for (Eigen::Index i = 0; i < n; ++i)
    if (presses[i] > 0 && force[i] * length < gap[i] * size)
      force[i] = 0;
  return force.matrix();
}

} // namespace

Eigen::VectorXd contact_forces(const Eigen::MatrixXd& compliance, const Eigen::VectorXd& gap0,
                               const std::vector<char>& may_pull, std::vector<char>& active) {
  const auto n = static_cast<std::size_t>(gap0.size());
  if (n == 0)
    return gap0;
  active.resize(n, 0);
  for (std::size_t i = 0; i < n; ++i)
    active[i] = active[i] != 0 || may_pull[i] != 0;
  Eigen::VectorXd force;
  std::size_t fewest = n + 1;
  int left = patience;
  for (int sets = 0; sets < iteration_cap; ++sets) {
    force = forces_of(compliance, gap0, active);
    const Eigen::VectorXd gap = gap0 + compliance * force;
    const double least_force = -rounding * force.cwiseAbs().maxCoeff(),
                 least_gap = -rounding * gap0.cwiseAbs().maxCoeff();
    std::vector<std::size_t> wrong;
    for (std::size_t i = 0; i < n; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      if (may_pull[i] == 0 && (active[i] != 0 ? force[k] < least_force : gap[k] < least_gap))
        wrong.push_back(i);
    }
    if (wrong.empty())
      break;
    if (wrong.size() < fewest) {
      fewest = wrong.size();
      left = patience;
    } else if (--left <= 0) {
      force = forces_by_interior_point(compliance, gap0, may_pull);
      for (std::size_t i = 0; i < n; ++i)
        active[i] = may_pull[i] != 0 || force[static_cast<Eigen::Index>(i)] > 0;
      break;
    }
    for (const std::size_t i : wrong)
      active[i] = active[i] == 0;
  }
  for (std::size_t i = 0; i < n; ++i)
    if (may_pull[i] == 0)
      force[static_cast<Eigen::Index>(i)] = std::max(0.0, force[static_cast<Eigen::Index>(i)]);
  return force;
}

} // namespace maille::deform
