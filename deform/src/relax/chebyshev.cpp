#include "relax/chebyshev.hpp"

#include <cmath>
#include <numbers>

namespace maille::deform {

namespace {

/// Relaxation damps eigenvalues down to this part of the largest, over the number of its steps: measured for the fewest
/// iterations of conjugate gradients.
constexpr double damped_range_times_steps = 0.13;

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

} // namespace maille::deform
