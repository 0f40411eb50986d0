#include "identify/identify.hpp"

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
constexpr double widest_interval = 4.6;  ///< of logarithms: a factor of 100 from end to end
constexpr double assumed_sigma = 0.01;   ///< of each value, where none is given: weights alone
constexpr double near_enough_for_values = 0.1; ///< beyond, steps are taken on logarithms of the data
constexpr double far_away = 1.4;               ///< other starts: a factor of 4
constexpr double straight = 0.1;               ///< logarithms over which slopes are taken not to change
constexpr Eigen::Index none = -1;

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

/// Logarithms of the unknowns, the numbers of the model there, and its slopes where they were taken.
struct Point {
  Vector theta, computed;
  double misfit = 0;
  Matrix slopes;
};

class Search {
public:
  Search(const std::vector<Unknown>& unknowns, const std::vector<Observation>& observations,
         const Model& model, const IdentifySettings& settings, const Control& control)
      : unknowns_(unknowns), observations_(observations), model_(model), settings_(settings),
        control_(control), n_(static_cast<Eigen::Index>(unknowns.size())),
        m_(static_cast<Eigen::Index>(observations.size())) {
    best_.theta.resize(n_);
    for (Eigen::Index j = 0; j < n_; ++j)
      best_.theta(j) = std::log(unknowns[j].start);
    found_.freedom = static_cast<int>(m_ - n_);
    found_.sigma_is_known = observations.front().sigma.has_value();
    double largest = 0;
    for (const Observation& one : observations)
      largest = std::max(largest, std::abs(one.value));
    wanted_.resize(m_);
    sigma_.resize(m_);
    for (Eigen::Index i = 0; i < m_; ++i) {
      const Observation& one = observations[i];
      wanted_(i) = one.value;
      // A value of zero says something, too: beside the others.
      sigma_(i) = one.sigma.value_or(assumed_sigma * std::max(std::abs(one.value), 1e-3 * largest));
    }
  }

  Identification run() {
    if (!evaluate(best_))
      return ended(IdentifyStatus::failed, "the model has no answer at the start");
    const IdentifyStatus status = descend(best_);
    switch (status) {
    case IdentifyStatus::interrupted:
      return ended(status, "stopped");
    case IdentifyStatus::failed:
      return ended(status, "the model has no answer beside " + values_in_words(best_.theta));
    case IdentifyStatus::budget_reached:
      return finish(status, fmt::format("{} solves did not bring the steps below {:g}", found_.solves,
                                        settings_.tolerance));
    default:
      start_elsewhere();
      return control_.should_stop() ? ended(IdentifyStatus::interrupted, "stopped") : finish(status, "");
    }
  }

private:
  bool evaluate(Point& point) {
    std::vector<double> values;
    for (const double t : point.theta)
      values.push_back(std::exp(t));
    ++found_.solves;
    const auto numbers = model_(values);
    if (!numbers)
      return false;
    point.computed.resize(m_);
    for (Eigen::Index i = 0; i < m_; ++i)
      point.computed(i) = (*numbers)[i];
    point.misfit = misfit(point.computed);
    return point.computed.allFinite();
  }

  /// Gauss and Newton's steps to the least misfit. @param fixed an unknown that stays as it is
  IdentifyStatus descend(Point& point, Eigen::Index fixed = none) {
    const int budget = found_.solves - 1 + settings_.solves_per_unknown * static_cast<int>(n_);
    while (true) {
      if (control_.should_stop())
        return IdentifyStatus::interrupted;
      if (found_.solves + n_ + 1 > budget)
        return IdentifyStatus::budget_reached;
      if (!differentiate(point, fixed))
        return IdentifyStatus::failed;
      const Vector step = limited(newton_step(point));
      // Else nothing nearer lies that way: the noise of the model's own algebra.
      if (step.cwiseAbs().maxCoeff() < settings_.tolerance || !advance(point, step))
        return IdentifyStatus::done;
    }
  }

  /// Takes the best of what other starts lead to, and keeps the others.
  void start_elsewhere() {
    for (const double sign : {1.0, -1.0}) {
      Point other;
      bool has_answer = false;
      for (double part = 1; part > 0.2 && !has_answer; part /= 2) {
        other.theta = best_.theta;
        for (Eigen::Index j = 0; j < n_; ++j)
          other.theta(j) += (j % 2 == 0 ? sign : -sign) * part * far_away;
        has_answer = !control_.should_stop() && evaluate(other);
      }
      if (!has_answer)
        continue;
      const IdentifyStatus status = descend(other);
      if (status == IdentifyStatus::done && other.misfit < best_.misfit)
        std::swap(best_, other);
      others_.push_back(std::move(other));
    }
  }

  double misfit(const Vector& computed) const {
    return ((computed - wanted_).array() / sigma_.array()).square().sum();
  }

  bool differentiate(Point& point, Eigen::Index fixed) {
    Matrix slopes = Matrix::Zero(m_, n_);
    for (Eigen::Index j = 0; j < n_; ++j) {
      if (j == fixed)
        continue;
      Point beside{point.theta, {}, 0, {}};
      beside.theta(j) += difference_step;
      if (!evaluate(beside))
        return false;
      slopes.col(j) = (beside.computed - point.computed) / difference_step;
    }
    point.slopes = std::move(slopes);
    return true;
  }

  /// True where every datum has the sign of what is computed, and some are far off.
  bool is_far(const Vector& computed) const {
    double farthest = 0;
    for (Eigen::Index i = 0; i < m_; ++i) {
      if (!(computed(i) * wanted_(i) > 0))
        return false;
      farthest = std::max(farthest, std::abs(std::log(computed(i) / wanted_(i))));
    }
    return farthest > near_enough_for_values;
  }

  /// The least-squares step of the linearised model; the shortest where it is not determined.
  Vector newton_step(const Point& point) const {
    Matrix a(m_, n_);
    Vector b(m_);
    const bool far = is_far(point.computed);
    for (Eigen::Index i = 0; i < m_; ++i) {
      const double computed = point.computed(i);
      // log: d(log f) = df / f, weighed by the relative sigma.
      const double weight = far ? std::abs(wanted_(i)) / (sigma_(i) * computed) : 1 / sigma_(i);
      a.row(i) = weight * point.slopes.row(i);
      b(i) = far ? std::abs(wanted_(i)) / sigma_(i) * std::log(wanted_(i) / computed)
                 : (wanted_(i) - computed) / sigma_(i);
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
  bool advance(Point& point, const Vector& step) {
    constexpr int most_halvings = 4;
    double part = 1;
    for (int i = 0; i <= most_halvings; ++i, part /= 2) {
      Point ahead{point.theta + part * step, {}, 0, point.slopes};
      if (!evaluate(ahead) || !(ahead.misfit < point.misfit))
        continue;
      point = std::move(ahead);
      return true;
    }
    return false;
  }

  std::string values_in_words(const Vector& theta) const {
    std::vector<std::string> words;
    for (Eigen::Index j = 0; j < n_; ++j)
      words.push_back(fmt::format("{} = {:.4g}", unknowns_[j].name, std::exp(theta(j))));
    return fmt::format("{}", fmt::join(words, ", "));
  }

  Identification ended(IdentifyStatus status, std::string message) {
    found_.status = status;
    found_.message = std::move(message);
    found_.unknowns.clear();
    for (Eigen::Index j = 0; j < n_; ++j)
      found_.unknowns.push_back({unknowns_[j].name, std::exp(best_.theta(j)), std::nullopt, false});
    if (best_.computed.size() > 0) {
      found_.computed.assign(best_.computed.begin(), best_.computed.end());
      found_.misfit = best_.misfit;
    }
    return found_;
  }

  /// How far an unknown can go until the least misfit beside it has risen by so much; a straight model says
  /// `reach`. @param along the change of all unknowns with it, of a straight model
  double profile(Eigen::Index j, const Vector& along, double reach, double rise) {
    constexpr int most_points = 5;
    constexpr double near_enough = 0.2, farthest = 3;
    const double sign = along(j);
    double low = 0, high = INFINITY;
    for (int i = 0; i < most_points && low < widest_interval && !control_.should_stop(); ++i) {
      Point point{best_.theta + reach * along, {}, 0, {}};
      point.theta(j) = best_.theta(j) + reach * sign;
      if (!evaluate(point)) { // constants that are none, or no answer: ends of what can be
        high = reach;
        reach = (low + high) / 2;
        continue;
      }
      if (n_ > 1)
        descend(point, j);
      const double rose = point.misfit - best_.misfit;
      if (std::abs(rose / rise - 1) < near_enough)
        return reach;
      (rose < rise ? low : high) = reach;
      reach *= std::sqrt(rise / std::max(rose, rise / (farthest * farthest)));
      if (!(reach > low && reach < high))
        reach = std::isfinite(high) ? (low + high) / 2 : farthest * low;
    }
    return std::max(reach, low);
  }

  /// Intervals, and what the data leave open.
  Identification finish(IdentifyStatus status, std::string message) {
    ended(status, std::move(message));
    if (best_.slopes.size() == 0)
      return found_;
    const Matrix a = sigma_.cwiseInverse().asDiagonal() * best_.slopes;
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
    Matrix covariance = Matrix::Zero(n_, n_);
    std::vector<std::string> open;
    for (Eigen::Index k = 0; k < n_; ++k) {
      const double s = std::max(svd.singularValues()(k), 1e-100);
      const Vector along = svd.matrixV().col(k);
      if (quantile * exact_enough / s > widest_interval / 2 ||
          !(s > least_influence * svd.singularValues()(0)))
        open.push_back(left_open(along));
      covariance += along * along.transpose() * (exact_enough * exact_enough / (s * s));
    }
    const bool is_settled = open.empty() && status == IdentifyStatus::done;
    for (Eigen::Index j = 0; j < n_; ++j) {
      Identified& one = found_.unknowns[j];
      double low = quantile * std::sqrt(covariance(j, j)), high = low;
      const Vector along = covariance.col(j) / covariance(j, j);
      if (is_settled && low <= widest_interval / 2 && low * along.cwiseAbs().maxCoeff() > straight) {
        const double rise = quantile * quantile * exact_enough * exact_enough;
        high = profile(j, along, high, rise);
        low = profile(j, -along, low, rise);
      }
      one.is_determined = status == IdentifyStatus::done && low + high <= widest_interval;
      if (has_scale && std::isfinite(low + high))
        one.interval = {std::exp(best_.theta(j) - low), std::exp(best_.theta(j) + high)};
      if (!one.is_determined && is_settled)
        open.push_back(one.name + ": values that differ by a factor of 100 fit them");
      // Where it fits as well from another start: to the data's error, at least to 1 % of what is assumed.
      const double as_well = best_.misfit + std::pow(quantile * std::max(exact_enough, 0.01), 2);
      for (const Point& other : others_)
        if (const double off = other.theta(j) - best_.theta(j);
            one.is_determined && other.misfit <= as_well &&
            std::abs(off) > std::max(off > 0 ? high : low, straight)) {
          one.is_determined = false;
          open.push_back(fmt::format("{}: {:.4g} fits as well", one.name, std::exp(other.theta(j))));
        }
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
        names.push_back(unknowns_[j].name);
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
  Vector wanted_, sigma_;
  Point best_;
  std::vector<Point> others_;
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
