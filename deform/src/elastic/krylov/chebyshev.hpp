#pragma once
/// Relaxation by Jacobi's steps, as multigrid wants it.

#include "elastic/krylov/conjugate_gradients.hpp"
#include "maille/materials/elasticity.hpp"

#include <cstddef>
#include <vector>

namespace maille::deform {

/// Jacobi's weights whose product is Chebyshev's polynomial on the upper part of the spectrum.
/// @param largest eigenvalue of inverse diagonal times operator, or a little more: beyond it the polynomial
///        grows fast
std::vector<float> chebyshev_weights(double largest, int steps);

/// Of an elasticity matrix in Voigt's notation: its largest eigenvalue over its smallest.
double stiffness_contrast(const Matrix6& stiffness);
/// Few enough of them for a contrast: stiffnesses of volume changes and shears alike.
constexpr int steps_of_low_contrast = 2;
/// How many steps before and after a coarse correction: nearer to incompressibility, and with stiffer fibres,
/// relaxation has a wider range to damp. Measured for the shortest time to 1e-3.
int relaxation_steps(double contrast);

/// The largest eigenvalue that conjugate gradients see, from their steps.
///
/// Source  Lanczos' tridiagonal matrix: Saad, Iterative Methods for Sparse Linear Systems, 2003, section
///         6.7.3
class RitzValues : public GradientWatch {
public:
  /// @param most steps of conjugate gradients
  explicit RitzValues(std::size_t most) : most_(most) {}
  bool goes_on() override { return steps_.size() < most_; }
  bool goes_on_after(double step, double product) override {
    steps_.push_back(step);
    products_.push_back(product);
    return true;
  }
  double largest() const;

private:
  std::size_t most_;
  std::vector<double> steps_, products_;
};

} // namespace maille::deform
