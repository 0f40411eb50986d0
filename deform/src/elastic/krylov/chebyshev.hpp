#pragma once
/// Relaxation by Jacobi's steps, as multigrid wants it.

#include <vector>

namespace maille::deform {

/// Jacobi's weights whose product is Chebyshev's polynomial on the upper part of the spectrum.
/// @param largest eigenvalue of inverse diagonal times operator, or a little more: beyond it the polynomial
///        grows fast
std::vector<float> chebyshev_weights(double largest, int steps);

/// The largest eigenvalue that conjugate gradients see, from their steps and betas.
///
/// Source  Lanczos' tridiagonal matrix: Saad, Iterative Methods for Sparse Linear Systems, 2003, section
///         6.7.3
class RitzValues {
public:
  /// @param beta by which the last direction went into this one; 0 at first
  void add(double step, double beta) {
    steps_.push_back(step);
    betas_.push_back(beta);
  }
  double largest() const;

private:
  std::vector<double> steps_, betas_;
};

} // namespace maille::deform
