/// Indices from the coefficients of polynomial chaos.

#include "study/sensitivity/intervals.hpp"
#include "study/sensitivity/polynomials.hpp"

#include <Eigen/QR>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace maille::studies {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int highest_degree = 20;
constexpr double most_unexplained = 1.0 / 3;

/// Samples that have a value, and the polynomials of each axis there.
struct Samples {
  std::vector<MatrixXd> of_axes; ///< see polynomials_of
  std::vector<int> most_of_axis; ///< degrees
  VectorXd values;
};

Samples kept_samples(const SampledValues& all) {
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < all.values.size(); ++i)
    if (all.values[i] && std::isfinite(*all.values[i]))
      kept.push_back(i);
  Samples samples;
  samples.values.resize(static_cast<Index>(kept.size()));
  for (std::size_t i = 0; i < kept.size(); ++i)
    samples.values[static_cast<Index>(i)] = *all.values[kept[i]];
  for (std::size_t axis = 0; axis < all.axes.size(); ++axis) {
    VectorXd at(static_cast<Index>(kept.size()));
    for (std::size_t i = 0; i < kept.size(); ++i)
      at[static_cast<Index>(i)] = all.points[kept[i]][axis];
    samples.of_axes.push_back(polynomials_of(all.axes[axis], at, highest_degree + 1));
    samples.most_of_axis.push_back(static_cast<int>(samples.of_axes.back().cols()) - 1);
  }
  return samples;
}

/// Orthogonal matching pursuit: takes one polynomial after another, that which is nearest to what is left.
class Pursuit {
public:
  /// @param products  the constant first @param order  of the samples: the first `n_seen` of them are fitted
  Pursuit(const MatrixXd& products, const VectorXd& values, const std::vector<Index>& order, Index n_seen)
      : products_(products(order, Eigen::all)), left_(values(order)), n_seen_(n_seen),
        sizes_(products_.topRows(n_seen).colwise().squaredNorm()), least_sizes_(1e-8 * sizes_) {}

  /// @return whether there was one to take
  bool take_next() {
    Index next = 0; // the constant, whatever it explains
    const auto seen = products_.topRows(n_seen_);
    if (!taken_.empty()) {
      const VectorXd gains =
          (sizes_.array() > least_sizes_.array())
              .select((seen.transpose() * left_.head(n_seen_)).array().square() / sizes_.array(), -1);
      if (gains.maxCoeff(&next) <= 0)
        return false;
    }
    const VectorXd direction = products_.col(next) / seen.col(next).norm();
    left_ -= direction.head(n_seen_).dot(left_.head(n_seen_)) * direction;
    const VectorXd shares = seen.transpose() * direction.head(n_seen_);
    products_.noalias() -= direction * shares.transpose();
    sizes_ = products_.topRows(n_seen_).colwise().squaredNorm();
    sizes_[next] = 0; // what others span is not taken again
    taken_.push_back(next);
    return true;
  }
  const std::vector<Index>& taken() const { return taken_; }
  double squares_of_unseen() const { return left_.tail(left_.size() - n_seen_).squaredNorm(); }

private:
  MatrixXd products_; ///< less what those that were taken span
  VectorXd left_;     ///< of the values
  Index n_seen_;
  VectorXd sizes_, least_sizes_; ///< squares, over what is seen
  std::vector<Index> taken_;
};

std::vector<Index> shuffled(Index n) {
  std::vector<Index> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), Index{0});
  std::mt19937_64 lot(1); // by hand: library distributions differ from one another
  for (std::size_t i = order.size(); i > 1; --i)
    std::swap(order[i - 1], order[lot() % i]);
  return order;
}

/// How many terms to take, and the mean square of the errors on samples that took no part in choice and fit.
struct Validation {
  std::size_t n_terms = 1;
  double error = INFINITY;
};

/// Five pursuits side by side, each without a fifth of the samples, until errors there no longer fall.
Validation cross_validation(const MatrixXd& products, const VectorXd& values, double enough) {
  constexpr Index n_folds = 5;
  const Index n = values.size();
  const std::vector<Index> order = shuffled(n);
  std::vector<Pursuit> pursuits;
  for (Index fold = 0; fold < n_folds; ++fold) {
    std::vector<Index> of_fold = order;
    const Index from = n * fold / n_folds, to = n * (fold + 1) / n_folds;
    std::rotate(of_fold.begin() + from, of_fold.begin() + to, of_fold.end());
    pursuits.emplace_back(products, values, of_fold, n - (to - from));
  }
  Validation best;
  const auto n_most = static_cast<std::size_t>(std::min({n / 2, products.cols(), Index{300}}));
  for (std::size_t k = 1; k <= std::min(n_most, best.n_terms + 10 + best.n_terms / 4); ++k) {
    double squares = 0;
    for (Pursuit& pursuit : pursuits) {
      pursuit.take_next();
      squares += pursuit.squares_of_unseen();
    }
    if (const double error = squares / static_cast<double>(n); error < best.error)
      best = {k, error};
    if (best.error <= enough)
      break;
  }
  return best;
}

/// Coefficients of the terms by least squares.
struct Fit {
  std::vector<Degrees> terms;
  MatrixXd inverse; ///< of the terms' products, a row a term
  VectorXd coefficients, left_out_errors;
};

Fit fit_of(const Samples& samples, std::vector<Degrees> terms) {
  const MatrixXd products = products_of(samples.of_axes, terms);
  const Index n = products.rows(), n_terms = products.cols();
  const Eigen::HouseholderQR<MatrixXd> factors(products);
  const MatrixXd basis = factors.householderQ() * MatrixXd::Identity(n, n_terms);
  Fit fit;
  fit.terms = std::move(terms);
  fit.inverse = factors.matrixQR().topRows(n_terms).triangularView<Eigen::Upper>().solve(basis.transpose());
  fit.coefficients = fit.inverse * samples.values;
  const VectorXd left = samples.values - products * fit.coefficients;
  fit.left_out_errors = left.array() / (1 - basis.rowwise().squaredNorm().array()).max(1e-6);
  return fit;
}

struct Model {
  std::vector<Degrees> terms;
  double error = INFINITY; ///< see Validation
};

/// The model with the degree and number of terms of least error, among those that the samples allow.
Model best_model(const Samples& samples, double variance) {
  const auto n = static_cast<double>(samples.values.size());
  const auto most = static_cast<std::size_t>(
      std::max(static_cast<double>(samples.of_axes.size()) + 1, std::min({4 * n, 1000.0, 1e6 / n})));
  const int most_total = std::accumulate(samples.most_of_axis.begin(), samples.most_of_axis.end(), 0);
  const double enough = 1e-10 * variance;
  std::vector<Degrees> best_candidates;
  Validation best;
  constexpr int patience = 3; // even and odd parts come in turns
  for (int degree = 1, last_better = 1; degree <= std::min(highest_degree, most_total); ++degree) {
    std::vector<Degrees> candidates = degrees_up_to(degree, samples.most_of_axis, most);
    if (candidates.empty() || degree > last_better + patience || best.error <= enough)
      break;
    const Validation found =
        cross_validation(products_of(samples.of_axes, candidates), samples.values, enough);
    if (found.error < 0.99 * best.error) {
      best = found;
      best_candidates = std::move(candidates);
      last_better = degree;
    }
  }
  Model model{{}, best.error};
  if (best_candidates.empty())
    return model;
  Pursuit pursuit(products_of(samples.of_axes, best_candidates), samples.values,
                  shuffled(samples.values.size()), samples.values.size());
  for (std::size_t k = 0; k < best.n_terms && pursuit.take_next(); ++k)
    model.terms.push_back(best_candidates[pursuit.taken().back()]);
  return model;
}

/// First-order indices, then total ones, from squares of coefficients.
std::vector<double> indices_of(const std::vector<Degrees>& terms, const VectorXd& coefficients) {
  const std::size_t n_axes = terms.front().size();
  std::vector<double> shares(2 * n_axes);
  double all = 0;
  for (std::size_t term = 0; term < terms.size(); ++term) {
    const auto n_parts = std::ranges::count_if(terms[term], [](int degree) { return degree > 0; });
    const double square = std::pow(coefficients[static_cast<Index>(term)], 2);
    all += n_parts > 0 ? square : 0;
    for (std::size_t axis = 0; axis < n_axes; ++axis)
      if (terms[term][axis] > 0) {
        shares[axis] += n_parts == 1 ? square : 0;
        shares[n_axes + axis] += square;
      }
  }
  for (double& share : shares)
    share = all > 0 ? share / all : 0;
  return shares;
}

/// Indices of fits to values that differ by errors of the fit's own size, each with the sign of a coin.
std::vector<std::vector<double>> bootstraps(const Fit& fit) {
  constexpr int n_bootstraps = 400;
  std::vector<std::vector<double>> all;
  std::mt19937_64 lot(1);
  for (int i = 0; i < n_bootstraps; ++i) {
    VectorXd errors = fit.left_out_errors;
    for (double& error : errors)
      error = (lot() >> 63U) != 0 ? error : -error;
    all.push_back(indices_of(fit.terms, fit.coefficients + fit.inverse * errors));
  }
  return all;
}

} // namespace

Sensitivity sobol_by_chaos(const SampledValues& all) {
  const std::size_t n_axes = all.axes.size();
  Sensitivity result = blank_sensitivity(n_axes, all.values);
  result.estimator = "polynomial chaos";
  const int n_least = std::max(10, 3 * static_cast<int>(n_axes));
  if (result.undetermined.empty() && result.n_used < n_least)
    result.undetermined =
        fmt::format("{} samples with a value, at least {} are needed", result.n_used, n_least);
  if (!result.undetermined.empty())
    return result;
  const Samples samples = kept_samples(all);
  const double variance = std::pow(result.deviation, 2);
  const Model model = best_model(samples, variance);
  result.unexplained = std::min(1.0, model.error / variance);
  if (model.terms.size() < 2 || result.unexplained > most_unexplained) {
    result.undetermined = fmt::format("polynomials explain {:.0f} % of the variance: more samples are needed",
                                      100 * (1 - result.unexplained));
    return result;
  }
  const Fit fit = fit_of(samples, model.terms);
  result.estimator += fmt::format(", {} terms", fit.terms.size());
  set_indices(result, indices_of(fit.terms, fit.coefficients), bootstraps(fit));
  return result;
}

} // namespace maille::studies
