#include "oracle/error_estimate.hpp"

#include <algorithm>
#include <cmath>

namespace maille::deform {

void ErrorEstimate::add(double change) {
  changes_.push_back(change);
  if (change == 0) {
    remaining_ = 0;
    return;
  }
  constexpr std::size_t shortest_window = 8;
  const std::size_t window = std::max(shortest_window, changes_.size() / 8);
  if (changes_.size() <= 2 * window)
    return;
  const double estimate = std::max(remaining_after(window), remaining_after(2 * window));
  if (change > rounding_)
    remaining_ = estimate;
  else // noise has no contraction; what was known before it is as good as it gets
    remaining_ = std::isfinite(estimate) ? std::min(estimate, remaining_) : std::min(remaining_, change);
}

double ErrorEstimate::remaining_after(std::size_t window) const {
  const double now = changes_.back(), before = changes_[changes_.size() - 1 - window];
  if (now >= before)
    return std::numeric_limits<double>::infinity();
  const double rho = std::pow(now / before, 1.0 / static_cast<double>(window));
  return now * rho / (1 - rho);
}

} // namespace maille::deform
