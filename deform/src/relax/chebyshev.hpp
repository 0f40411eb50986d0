#pragma once
/// Relaxation by Jacobi's steps, as multigrid wants it.

#include <vector>

namespace maille::deform {

/// Jacobi's weights whose product is Chebyshev's polynomial on the upper part of the spectrum.
/// @param largest eigenvalue of inverse diagonal times operator
std::vector<float> chebyshev_weights(double largest, int steps);

} // namespace maille::deform
