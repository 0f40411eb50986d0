#pragma once
/// Relaxation by Jacobi's steps, as multigrid wants it.

#include "elastic/krylov/conjugate_gradients.hpp"
#include "maille/materials/elasticity.hpp"

#include <cstddef>
#include <vector>

namespace maille::deform {

/// On a largest eigenvalue that was found by iteration, which comes from below.
inline constexpr double safety_of_eigenvalue = 1.05;

/// Jacobi's weights whose product is Chebyshev's polynomial on the upper part of the spectrum.
/// @param largest eigenvalue of inverse diagonal times operator, or a little more: beyond it the polynomial
///        grows fast
std::vector<float> chebyshev_weights(double largest, int steps);

/// Ratio of the largest to the smallest eigenvalue of an elasticity matrix in Voigt notation.
double stiffness_contrast(const Matrix6& stiffness);
/// Few enough of them for a contrast: stiffnesses of volume changes and shears alike.
constexpr int steps_of_low_contrast = 2;
/// How many steps before and after a coarse correction: nearer to incompressibility, and with stiffer fibres,
/// relaxation has a wider range to damp. Measured for the shortest time to 1e-3.
int relaxation_steps(double contrast);

/// Where the search for the largest eigenvalue begins: a right-hand side of -1 or 1, the same on every
/// machine, in units of the diagonal. The obvious version of noise_entries (masked_kernel.hpp).
/// @param i entry; @param inverse of its diagonal, 0 where it is fixed
float eigenvalue_noise(std::size_t i, float inverse);
/// Of inverse diagonal times operator, or a little more, from ten steps of conjugate gradients that are
/// preconditioned by the diagonal.
///
/// Source  Lanczos' tridiagonal matrix: Saad, Iterative Methods for Sparse Linear Systems, 2003, section
///         6.7.3
double largest_eigenvalue_seen_by(GradientSpace& space);

} // namespace maille::deform
