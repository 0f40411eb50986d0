#include "world/surface/contact_program.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <vector>

namespace maille::deform {

namespace {

constexpr int most_sets = 200, patience = 5;
/// Of the largest entry: less than this is rounding.
constexpr double rounding = 1e-12;

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
    const Eigen::VectorXd found = of_set.ldlt().solve(missing);
    force(set) = found;
  }
  return force;
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
  for (int sets = 0; sets < most_sets; ++sets) {
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
      wrong = {wrong.back()}; // by the rule of Murty this ends
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
