#pragma once
/// How far an iteration that contracts slowly still is from its end.

#include <limits>
#include <vector>

namespace maille::deform {

/// Estimates the error that remains from the changes of successive sweeps: if every change is rho times the
/// one before, those still to come add up to change * rho / (1 - rho).
///
/// rho is the geometric mean over the last eighth of the sweeps and over the last quarter, whichever says
/// more is left: one window alone is fooled when a limit becomes active or the largest change changes place.
class ErrorEstimate {
public:
  /// @param rounding changes of this size are noise: the iteration can do no better [m]
  explicit ErrorEstimate(double rounding) : rounding_(rounding) {}
  /// @param change the largest change of the latest sweep [m]
  void add(double change);
  /// What remains [m]; +infinity while nothing can be said.
  double remaining() const { return remaining_; }

private:
  double remaining_after(std::size_t window) const;

  double rounding_;
  double remaining_ = std::numeric_limits<double>::infinity();
  std::vector<double> changes_;
};

} // namespace maille::deform
