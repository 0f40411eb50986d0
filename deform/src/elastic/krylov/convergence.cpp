#include "elastic/krylov/convergence.hpp"

#include "lattice/tolerances.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace maille::deform {

namespace {

/// Give up after this many iterations without a better residual.
constexpr std::int64_t patience = 1000;
/// Compare the residual with its rounding after this many iterations without a better one, and again after
/// as many.
constexpr std::int64_t steps_between_doubts = 10;
/// Residuals that are carried along drift away from the true ones by rounding.
constexpr std::int64_t steps_between_residuals = 50;
/// Share of the tolerance that the estimate must reach: slender bodies converge in leaps, and the remaining
/// error may lie along a soft direction.
constexpr double share_of_tolerance = 1.0 / 3;
/// Steps after which the energy that they brought tells how far the state was from the answer.
constexpr std::size_t delay = 3;
constexpr double least_rate = 0.02; ///< smaller measured rates are not trusted

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

void Convergence::restart() {
  diagonal_.clear();
  beside_square_.clear();
}

bool Convergence::is_measured() const {
  return gains_.size() >= delay;
}

void Convergence::add(double step, double product, double scale) {
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
void Convergence::find_smallest() {
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

/// Reduction of the product per step over the last steps; 1 without convergence.
double Convergence::rate() const {
  const std::size_t n = products_.size();
  if (n < delay)
    return 1;
  const double ratio = std::max(products_[n - 1] / products_[n - 2], products_[n - 2] / products_[n - 3]);
  return std::clamp(ratio, least_rate, 1.0);
}

/// The energy norm after the last step.
double Convergence::of_steps(double energy) const {
  if (!is_measured())
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

/// The energy norm, from a residual.
double Convergence::of_residual(double product, double energy) const {
  constexpr double not_met_yet = 3; // the smallest eigenvalue may lie below the smallest Ritz value by this
  return std::min(1.0, std::sqrt(not_met_yet * std::max(0.0, product) / smallest_ / not_nothing(energy)));
}

/// The displacement norm holds if steps go on shrinking as the residual does.
double Convergence::worse_of_both(double of_energy, const State& state) const {
  const double rate_of_norm = std::sqrt(rate());
  const double of_displacement =
      rate_of_norm < 1 && state.length > 0
          ? std::sqrt(state.moved / state.length) * rate_of_norm / (1 - rate_of_norm)
          : 1;
  return std::min(1.0, std::max(of_energy, of_displacement));
}

bool Convergence::is_within(double energy) {
  residual_ = of_steps(energy);
  return residual_ <= tolerance_;
}

bool Convergence::starts_within(double product, double energy) {
  if (!knows_spectrum_ || !(product > 0))
    return false;
  const double residual = of_residual(product, energy);
  if (residual > tolerance_)
    return false;
  residual_ = residual;
  return true;
}

/// A product above this share of the energy is no rounding: then a preconditioner in float32 has met matter
/// whose moduli it cannot tell from nothing.
bool Convergence::is_at_rounding(double product, double energy, const std::function<double()>& of_rounding) {
  constexpr double margin = 100; // ten times in that norm: sums over neighbours round more than once
  first_ = std::max(first_, product);
  return std::abs(product) <= rounding * std::max(energy, first_) &&
         (!of_rounding || std::abs(product) <= margin * of_rounding());
}

Convergence::End Convergence::without_descent(double product, double energy,
                                              const std::function<double()>& product_of_rounding) {
  if (product != 0 && !is_at_rounding(product, energy, product_of_rounding))
    return End::stagnated;
  residual_ = of_residual(product, std::max(energy, first_));
  return End::converged;
}

bool Convergence::should_recompute(const State& state, std::int64_t iteration) {
  residual_ = worse_of_both(of_steps(state.energy), state);
  is_to_confirm_ = residual_ <= share_of_tolerance * tolerance_;
  return is_to_confirm_ || iteration % steps_between_residuals == 0;
}

std::optional<Convergence::End> Convergence::judge(double product, const State& state, std::int64_t iteration,
                                                   const std::function<double()>& product_of_rounding) {
  if (!std::isfinite(product) || !std::isfinite(state.energy))
    return End::diverged;
  first_ = std::max(first_, product);
  if (is_to_confirm_) {
    residual_ = worse_of_both(of_residual(product, state.energy), state);
    if (residual_ <= share_of_tolerance * tolerance_)
      return End::converged;
  }
  if (best_ == 0 || product < 0.9 * best_) {
    best_ = product;
    best_at_ = iteration;
  }
  const std::int64_t stalled = iteration - best_at_;
  if (!(product > 0) || stalled > patience)
    return without_descent(product, state.energy, product_of_rounding);
  const bool is_in_doubt = stalled > 0 && stalled % steps_between_doubts == 0;
  if (is_in_doubt && without_descent(product, state.energy, product_of_rounding) == End::converged)
    return End::converged;
  return std::nullopt;
}

} // namespace maille::deform
