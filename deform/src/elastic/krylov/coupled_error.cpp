#include "elastic/krylov/coupled_error.hpp"

namespace maille::deform {

namespace {

double not_nothing(double energy) {
  return std::max(energy, std::sqrt(std::numeric_limits<double>::min()));
}

/// Number of eigenvalues of a symmetric tridiagonal matrix below x: negative pivots of its factors (Sturm
/// sequence).
std::size_t count_below(const std::vector<double>& diagonal, const std::vector<double>& beside_square,
                        double x) {
  std::size_t below = 0;
  double pivot = 1;
  for (std::size_t i = 0; i < diagonal.size(); ++i) {
    pivot = diagonal[i] - x - (i > 0 ? beside_square[i - 1] / pivot : 0);
    if (pivot == 0)
      pivot = -1e-300;
    below += pivot < 0 ? 1 : 0;
  }
  return below;
}

} // namespace

void CoupledError::restart() {
  diagonal_.clear();
  beside_square_.clear();
}

void CoupledError::add(double step, double product, double scale) {
  gains_.push_back(step * product * scale * scale);
  products_.push_back(product * scale * scale);
  double diagonal = 1 / step;
  if (!diagonal_.empty()) {
    const double ratio = product / last_product_;
    diagonal += ratio / last_step_;
    beside_square_.push_back(ratio / (last_step_ * last_step_));
  }
  diagonal_.push_back(diagonal);
  last_step_ = step;
  last_product_ = product;
  find_smallest();
}

/// Bisection to a twentieth; the value only falls from step to step. Below `least` the coefficients are
/// rounding.
void CoupledError::find_smallest() {
  constexpr double least = 1e-30;
  if (diagonal_.size() < 2 || smallest_ <= least || count_below(diagonal_, beside_square_, smallest_) == 0)
    return;
  double low = smallest_ / 2, high = smallest_;
  while (count_below(diagonal_, beside_square_, low) > 0 && low > least) {
    high = low;
    low /= 2;
  }
  while (high > 1.05 * low) {
    const double middle = std::sqrt(low * high);
    (count_below(diagonal_, beside_square_, middle) > 0 ? high : low) = middle;
  }
  smallest_ = low;
}

double CoupledError::rate() const {
  const std::size_t n = products_.size();
  if (n < delay)
    return 1;
  const double ratio = std::max(products_[n - 1] / products_[n - 2], products_[n - 2] / products_[n - 3]);
  return std::clamp(ratio, least_rate, 1.0);
}

double CoupledError::relative_to(double energy) const {
  if (gains_.size() < delay)
    return 1;
  const double* const last = &gains_.back();
  const double of_gains = std::max({last[0] / last[-1], last[-1] / last[-2], least_rate});
  if (!(of_gains < 1))
    return 1;
  // If the energies go on falling at the slower of their last two rates; twice that, to be safe.
  const double by_energies = 2 * std::sqrt(last[0] * of_gains / (1 - of_gains) / not_nothing(energy));
  // The step has taken at least so much off the residual as the last one did.
  const double by_residual = of_residual(rate() * products_.back(), energy);
  return std::min(1.0, std::max(by_energies, by_residual));
}

double CoupledError::of_residual(double product, double energy) const {
  constexpr double not_met_yet = 3; // the smallest eigenvalue may lie below the smallest Ritz value by this
  return std::min(1.0, std::sqrt(not_met_yet * std::max(0.0, product) / smallest_ / not_nothing(energy)));
}

} // namespace maille::deform
