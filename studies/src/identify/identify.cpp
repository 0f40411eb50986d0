#include "maille/studies/identify.hpp"

#include <Eigen/Dense>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

namespace maille::studies {

namespace {

constexpr double difference_step = 1e-2; ///< of logarithms: far above the rounding of the model's algebra
constexpr double least_influence = 1e-4; ///< over the greatest, that is more than that rounding
constexpr double longest_step = 2.3;     ///< a factor of ten
constexpr double widest_interval = 4.6;  ///< half a width of logarithms: a factor of 100 either way
constexpr double assumed_sigma = 0.01;   ///< of each value, where none is given: weights alone
constexpr double near_enough_for_values = 0.1; ///< beyond, steps are taken on logarithms of the data

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

class Search {
public:
  Search(const std::vector<Unknown>& unknowns, const std::vector<Observation>& observations,
         const Model& model, const IdentifySettings& settings, const Control& control)
      : unknowns_(unknowns), observations_(observations), model_(model), settings_(settings),
        control_(control), n_(static_cast<Eigen::Index>(unknowns.size())),
        m_(static_cast<Eigen::Index>(observations.size())) {
    theta_.resize(n_);
    for (Eigen::Index j = 0; j < n_; ++j)
      theta_(j) = std::log(unknowns[static_cast<std::size_t>(j)].start);
    found_.freedom = static_cast<int>(m_ - n_);
    found_.sigma_is_known = observations.front().sigma.has_value();
    double largest = 0;
    for (const Observation& one : observations)
      largest = std::max(largest, std::abs(one.value));
    wanted_.resize(m_);
    sigma_.resize(m_);
    for (Eigen::Index i = 0; i < m_; ++i) {
      const Observation& one = observations[static_cast<std::size_t>(i)];
      wanted_(i) = one.value;
      // A value of zero says something, too: beside the others.
      sigma_(i) = one.sigma.value_or(assumed_sigma * std::max(std::abs(one.value), 1e-3 * largest));
    }
  }

  Identification run() {
    const auto start = at(theta_);
    if (!start)
      return ended(IdentifyStatus::failed, "the model has no answer at the start");
    computed_ = *start;
    const int budget = settings_.solves_per_unknown * static_cast<int>(n_);
    Matrix slopes;
    bool is_small = false;
    while (!is_small) {
      if (control_.should_stop())
        return ended(IdentifyStatus::interrupted, "stopped");
      if (found_.solves + n_ + 1 > budget)
        return finish(
            slopes, IdentifyStatus::budget_reached,
            fmt::format("{} solves did not bring the steps below {:g}", found_.solves, settings_.tolerance));
      if (!differentiate(slopes))
        return ended(IdentifyStatus::failed, "the model has no answer beside " + values_in_words());
      const Vector step = limited(newton_step(slopes));
      is_small = step.cwiseAbs().maxCoeff() < settings_.tolerance;
      if (!is_small && !advance(step))
        is_small = true; // nothing nearer lies that way: the noise of the model's own algebra
    }
    return finish(slopes, IdentifyStatus::done, "");
  }

private:
  std::optional<Vector> at(const Vector& theta) {
    std::vector<double> values;
    for (const double t : theta)
      values.push_back(std::exp(t));
    ++found_.solves;
    const auto numbers = model_(values);
    if (!numbers)
      return std::nullopt;
    Vector computed(m_);
    for (Eigen::Index i = 0; i < m_; ++i)
      computed(i) = (*numbers)[static_cast<std::size_t>(i)];
    return computed.allFinite() ? std::optional(computed) : std::nullopt;
  }

  double misfit(const Vector& computed) const {
    return ((computed - wanted_).array() / sigma_.array()).square().sum();
  }

  bool differentiate(Matrix& slopes) {
    slopes.resize(m_, n_);
    for (Eigen::Index j = 0; j < n_; ++j) {
      Vector beside = theta_;
      beside(j) += difference_step;
      const auto computed = at(beside);
      if (!computed)
        return false;
      slopes.col(j) = (*computed - computed_) / difference_step;
    }
    return true;
  }

  /// True where every datum has the sign of what is computed, and some are far off.
  bool is_far() const {
    double farthest = 0;
    for (Eigen::Index i = 0; i < m_; ++i) {
      if (!(computed_(i) * wanted_(i) > 0))
        return false;
      farthest = std::max(farthest, std::abs(std::log(computed_(i) / wanted_(i))));
    }
    return farthest > near_enough_for_values;
  }

  /// The least-squares step of the linearised model; the shortest where it is not determined.
  Vector newton_step(const Matrix& slopes) const {
    Matrix a(m_, n_);
    Vector b(m_);
    const bool far = is_far();
    for (Eigen::Index i = 0; i < m_; ++i) {
      // log: d(log f) = df / f, weighed by the relative sigma.
      const double weight = far ? std::abs(wanted_(i)) / (sigma_(i) * computed_(i)) : 1 / sigma_(i);
      a.row(i) = weight * slopes.row(i);
      b(i) = far ? std::abs(wanted_(i)) / sigma_(i) * std::log(wanted_(i) / computed_(i))
                 : (wanted_(i) - computed_(i)) / sigma_(i);
    }
    Eigen::JacobiSVD<Matrix> svd(a, Eigen::ComputeThinU | Eigen::ComputeThinV);
    svd.setThreshold(least_influence);
    return svd.solve(b);
  }

  static Vector limited(Vector step) {
    const double length = step.cwiseAbs().maxCoeff();
    if (length > longest_step)
      step *= longest_step / length;
    return step;
  }

  /// Goes as far along the step as the misfit falls. @return false where it falls nowhere
  bool advance(const Vector& step) {
    constexpr int most_halvings = 4;
    const double before = misfit(computed_);
    double part = 1;
    for (int i = 0; i <= most_halvings; ++i, part /= 2) {
      const auto computed = at(theta_ + part * step);
      if (!computed || !(misfit(*computed) < before))
        continue;
      theta_ += part * step;
      computed_ = *computed;
      return true;
    }
    return false;
  }

  std::string values_in_words() const {
    std::vector<std::string> words;
    for (Eigen::Index j = 0; j < n_; ++j)
      words.push_back(
          fmt::format("{} = {:.4g}", unknowns_[static_cast<std::size_t>(j)].name, std::exp(theta_(j))));
    return fmt::format("{}", fmt::join(words, ", "));
  }

  Identification ended(IdentifyStatus status, std::string message) {
    found_.status = status;
    found_.message = std::move(message);
    found_.unknowns.clear();
    for (Eigen::Index j = 0; j < n_; ++j)
      found_.unknowns.push_back(
          {unknowns_[static_cast<std::size_t>(j)].name, std::exp(theta_(j)), std::nullopt, true});
    if (computed_.size() > 0) {
      found_.computed.assign(computed_.begin(), computed_.end());
      found_.misfit = misfit(computed_);
    }
    return found_;
  }

  /// Intervals, and what the data leave open.
  Identification finish(const Matrix& slopes, IdentifyStatus status, std::string message) {
    ended(status, std::move(message));
    if (slopes.size() == 0)
      return found_;
    const Matrix a = sigma_.cwiseInverse().asDiagonal() * slopes;
    const Eigen::JacobiSVD<Matrix> svd(a, Eigen::ComputeThinU | Eigen::ComputeThinV);
    const bool has_scale = found_.sigma_is_known || found_.freedom > 0;
    const double scale = found_.sigma_is_known ? 1
                         : found_.freedom > 0  ? std::sqrt(found_.misfit / found_.freedom)
                                               : 1;
    const double quantile = found_.sigma_is_known || found_.freedom == 0
                                ? boost::math::quantile(boost::math::normal(), 0.975)
                                : boost::math::quantile(boost::math::students_t(found_.freedom), 0.975);
    // Exact data tell as much as the model's own rounding lets them.
    const double exact_enough = std::max(scale, 1e-6);
    Vector variance = Vector::Zero(n_);
    std::vector<std::string> open;
    for (Eigen::Index k = 0; k < n_; ++k) {
      const double s = svd.singularValues()(k);
      const Vector along = svd.matrixV().col(k);
      const double half_width = s > 0 ? quantile * exact_enough / s : INFINITY;
      if (half_width > widest_interval || !(s > least_influence * svd.singularValues()(0)))
        open.push_back(left_open(along));
      variance += along.cwiseAbs2() * (s > 0 ? exact_enough * exact_enough / (s * s) : INFINITY);
    }
    for (Eigen::Index j = 0; j < n_; ++j) {
      Identified& one = found_.unknowns[static_cast<std::size_t>(j)];
      const double half_width = quantile * std::sqrt(variance(j));
      one.is_determined = half_width <= widest_interval;
      if (has_scale && std::isfinite(half_width))
        one.interval = {std::exp(theta_(j) - half_width), std::exp(theta_(j) + half_width)};
    }
    if (!open.empty() && status == IdentifyStatus::done) {
      found_.status = IdentifyStatus::undetermined;
      found_.message = fmt::format("the data do not determine {}", fmt::join(open, ", nor "));
    }
    return found_;
  }

  /// A direction of logarithms along which the data stay as they are.
  std::string left_open(const Vector& along) const {
    constexpr double of_account = 0.1;
    std::vector<std::string> names;
    for (Eigen::Index j = 0; j < n_; ++j)
      if (std::abs(along(j)) > of_account)
        names.push_back(unknowns_[static_cast<std::size_t>(j)].name);
    if (names.size() == 1)
      return names.front() + ": a change of it changes them by less than they are off";
    return fmt::format("{} one by one: changed together they leave the data as they are",
                       fmt::join(names, " and "));
  }

  const std::vector<Unknown>& unknowns_;
  const std::vector<Observation>& observations_;
  const Model& model_;
  const IdentifySettings& settings_;
  const Control& control_;
  Eigen::Index n_, m_;
  Vector theta_, wanted_, sigma_, computed_;
  Identification found_;
};

} // namespace

std::string_view to_string(IdentifyStatus status) {
  switch (status) {
  case IdentifyStatus::done:
    return "done";
  case IdentifyStatus::undetermined:
    return "undetermined";
  case IdentifyStatus::budget_reached:
    return "budget_reached";
  case IdentifyStatus::interrupted:
    return "interrupted";
  default:
    return "failed";
  }
}

Identification identify(const std::vector<Unknown>& unknowns, const std::vector<Observation>& observations,
                        const Model& model, const IdentifySettings& settings, const Control& control) {
  return Search(unknowns, observations, model, settings, control).run();
}

} // namespace maille::studies
