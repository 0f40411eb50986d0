#pragma once
/// The one loop of conjugate gradients that all solvers go through.
///
/// Scheme: K u = f is solved by steps along directions p that are conjugate: p . K p' = 0. B is a
/// preconditioner, r = f - K u the residual, z = B r the correction, beta the quotient of r . z and that of
/// the step before, p = z + beta p. A GradientSpace has the vectors, in any storage and precision; a
/// GradientWatch decides when the loop ends.
///
/// Exact: the step length, which takes the energy to its minimum along p. Heuristic: when to end, in the
/// watches.

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

namespace maille::deform {

/// Vector space of conjugate gradients: a residual r, a correction z, a direction p and its image q = K p, in
/// any storage and precision.
class GradientSpace {
public:
  virtual ~GradientSpace() = default;
  /// z = B r. @return r . z
  virtual double precondition() = 0;
  /// p = z + beta p; q = K p. @param product r . z @return the length of the step to the least energy along
  /// p; nothing where p . K p is not positive
  virtual std::optional<double> find_step(double beta, double product) = 0;
  /// x += step p, r -= step q.
  virtual void take_step(double step) = 0;
  /// r . z of the new residual and the correction before it, which a preconditioner that changes leaves
  /// (Polak and Ribiere's rule).
  virtual double overlap() const { return 0; }
};

/// Decides when they end.
class GradientWatch {
public:
  virtual ~GradientWatch() = default;
  /// Before an iteration.
  virtual bool should_continue() { return true; }
  /// After the correction was found. @param product r . z, of any sign
  virtual bool should_continue_from(double product) {
    (void)product;
    return true;
  }
  /// After the step was taken. @param product r . z before it
  virtual bool should_continue_after(double step, double product) = 0;
};

/// The watch ended it; or r . z, or the curvature p . K p, is not positive and finite.
enum class GradientsEnd { told, no_descent, no_curvature };

/// Source  Saad 2003, Iterative Methods for Sparse Linear Systems, algorithm 9.1; Notay 2000, Flexible
///         conjugate gradients, section 2
inline GradientsEnd conjugate_gradients(GradientSpace& space, GradientWatch& watch) {
  double last = 0;
  while (watch.should_continue()) {
    const double now = space.precondition();
    if (!watch.should_continue_from(now))
      break;
    if (!(now > 0) || !std::isfinite(now))
      return GradientsEnd::no_descent;
    const double beta = last > 0 ? std::max(0.0, (now - space.overlap()) / last) : 0;
    const auto step = space.find_step(beta, now);
    if (!step)
      return GradientsEnd::no_curvature;
    space.take_step(*step);
    last = now;
    if (!watch.should_continue_after(*step, now))
      break;
  }
  return GradientsEnd::told;
}

/// Stops after `most` iterations, when r . B r has fallen to `reduction` squared of its first value or to
/// `floor`, or to `enough` after an iteration, or when must_stop() says so.
class ReductionWatch : public GradientWatch {
public:
  /// @param must_stop none: never
  ReductionWatch(int most, double reduction, std::function<bool()> must_stop = nullptr, double floor = 0,
                 double enough = 0)
      : most_(most), reduction_(reduction), floor_(floor), enough_(enough), must_stop_(std::move(must_stop)) {
  }
  bool should_continue() override { return iterations_ < most_ && !(must_stop_ && must_stop_()); }
  bool should_continue_from(double product) override {
    if (iterations_ == 0)
      first_ = product;
    return product > floor_ &&
           (iterations_ == 0 || product > std::max(enough_, reduction_ * reduction_ * first_));
  }
  bool should_continue_after(double, double) override {
    ++iterations_;
    return true;
  }
  int iterations() const { return iterations_; }
  double first() const { return first_; } ///< r . B r

private:
  int most_;
  double reduction_, floor_, enough_;
  std::function<bool()> must_stop_;
  int iterations_ = 0;
  double first_ = 0;
};

} // namespace maille::deform
