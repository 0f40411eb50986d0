#include "study/sensitivity/polynomials.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

namespace maille::studies {

namespace {

/// Legendre's, with mean squares of 1 over [-1, 1].
Eigen::MatrixXd legendre(const Eigen::VectorXd& at, int n_degrees) {
  Eigen::MatrixXd p(at.size(), n_degrees);
  p.col(0).setOnes();
  if (n_degrees > 1)
    p.col(1) = at;
  for (int n = 2; n < n_degrees; ++n)
    p.col(n) = ((2 * n - 1) * at.cwiseProduct(p.col(n - 1)) - (n - 1) * p.col(n - 2)) / n;
  for (int n = 0; n < n_degrees; ++n)
    p.col(n) *= std::sqrt(2 * n + 1.0);
  return p;
}

/// Adds degrees of one axis after another.
void extend(int left, std::size_t axis, const std::vector<int>& most_of_axis, Degrees& current,
            std::vector<Degrees>& all, std::size_t most) {
  const int room =
      std::accumulate(most_of_axis.begin() + static_cast<std::ptrdiff_t>(axis), most_of_axis.end(), 0);
  if (all.size() > most || left > room)
    return;
  if (axis + 1 == most_of_axis.size()) {
    current[axis] = left;
    all.push_back(current);
    return;
  }
  for (int degree = std::min(left, most_of_axis[axis]); degree >= 0; --degree) {
    current[axis] = degree;
    extend(left - degree, axis + 1, most_of_axis, current, all, most);
  }
}

} // namespace

Eigen::MatrixXd polynomials_of(const SampledAxis& axis, const Eigen::VectorXd& at, int n_degrees) {
  if (axis.levels.empty())
    return legendre(at, n_degrees);
  const Eigen::VectorXd levels =
      Eigen::Map<const Eigen::VectorXd>(axis.levels.data(), static_cast<Eigen::Index>(axis.levels.size()));
  const auto n_different = static_cast<int>(std::set(axis.levels.begin(), axis.levels.end()).size());
  const int n = std::min(n_degrees, n_different);
  // Gram and Schmidt on the levels, twice; what is done there is done at the samples.
  Eigen::MatrixXd on_levels = legendre(levels, n), p = legendre(at, n);
  for (int k = 0; k < n; ++k) {
    for (int pass = 0; pass < 2; ++pass)
      for (int j = 0; j < k; ++j) {
        const double share = on_levels.col(j).dot(on_levels.col(k)) / static_cast<double>(levels.size());
        on_levels.col(k) -= share * on_levels.col(j);
        p.col(k) -= share * p.col(j);
      }
    const double size = on_levels.col(k).norm() / std::sqrt(static_cast<double>(levels.size()));
    on_levels.col(k) /= size;
    p.col(k) /= size;
  }
  return p;
}

std::vector<Degrees> degrees_up_to(int total, const std::vector<int>& most_of_axis, std::size_t most) {
  std::vector<Degrees> all;
  Degrees current(most_of_axis.size());
  for (int sum = 0; sum <= total && all.size() <= most; ++sum)
    extend(sum, 0, most_of_axis, current, all, most);
  if (all.size() > most)
    all.clear();
  return all;
}

Eigen::MatrixXd products_of(const std::vector<Eigen::MatrixXd>& of_axes,
                            const std::vector<Degrees>& degrees) {
  Eigen::MatrixXd products =
      Eigen::MatrixXd::Ones(of_axes.front().rows(), static_cast<Eigen::Index>(degrees.size()));
  for (std::size_t term = 0; term < degrees.size(); ++term)
    for (std::size_t axis = 0; axis < of_axes.size(); ++axis)
      if (degrees[term][axis] > 0)
        products.col(static_cast<Eigen::Index>(term)).array() *=
            of_axes[axis].col(degrees[term][axis]).array();
  return products;
}

} // namespace maille::studies
