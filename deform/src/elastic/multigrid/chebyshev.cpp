#include "elastic/multigrid/chebyshev.hpp"

#include <Eigen/Eigenvalues>

#include <cmath>
#include <numbers>

namespace maille::deform {

namespace {

/// Smallest damped eigenvalue over the largest, times the number of steps. Measured for the fewest iterations
/// of conjugate gradients.
constexpr double damped_range_times_steps = 0.13;

constexpr std::size_t steps_for_eigenvalue = 10;

/// Records the steps of conjugate gradients.
class Steps : public GradientWatch {
public:
  bool should_continue() override { return steps_.size() < steps_for_eigenvalue; }
  bool should_continue_after(double step, double product) override {
    steps_.push_back(step);
    products_.push_back(product);
    return true;
  }
  double largest_eigenvalue() const;

private:
  std::vector<double> steps_, products_;
};

double Steps::largest_eigenvalue() const {
  const auto n = static_cast<Eigen::Index>(steps_.size());
  if (n == 0)
    return 1;
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    T(i, i) = 1 / steps_[k] + (k > 0 ? products_[k] / products_[k - 1] / steps_[k - 1] : 0);
    if (i + 1 < n)
      T(i, i + 1) = T(i + 1, i) = std::sqrt(products_[k + 1] / products_[k]) / steps_[k];
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(T, Eigen::EigenvaluesOnly).eigenvalues()(n - 1);
}

} // namespace

std::vector<float> chebyshev_weights(double largest, int steps) {
  const double smallest = damped_range_times_steps / steps * largest;
  const double middle = (largest + smallest) / 2, half = (largest - smallest) / 2;
  std::vector<float> weights;
  for (int k = 0; k < steps; ++k)
    weights.push_back(
        static_cast<float>(1 / (middle + half * std::cos(std::numbers::pi * (2 * k + 1) / (2 * steps)))));
  return weights;
}

double stiffness_contrast(const Matrix6& stiffness) {
  const Eigen::SelfAdjointEigenSolver<Matrix6> modes(stiffness, Eigen::EigenvaluesOnly);
  return modes.eigenvalues()(5) / modes.eigenvalues()(0);
}

int relaxation_steps(double contrast) {
  return contrast < 8 ? steps_of_low_contrast : contrast < 30 ? 4 : 6;
}

double largest_eigenvalue_seen_by(GradientSpace& space) {
  Steps steps;
  conjugate_gradients(space, steps);
  return safety_of_eigenvalue * steps.largest_eigenvalue();
}

} // namespace maille::deform
