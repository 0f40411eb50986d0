#pragma once
/// Chebyshev relaxation: Jacobi steps whose weights make a Chebyshev polynomial, and the eigenvalues that
/// they need.

#include "elastic/krylov/conjugate_gradients.hpp"
#include "maille/materials/elasticity.hpp"

#include <cstddef>
#include <vector>

namespace maille::deform {

/// Factor on an iterated largest eigenvalue, which approaches the true one from below.
inline constexpr double safety_of_eigenvalue = 1.05;

/// Jacobi weights whose error polynomial is Chebyshev's on the upper part of the spectrum.
/// @param largest upper bound of the eigenvalues of inverse diagonal times operator: beyond it the polynomial
/// grows fast
std::vector<float> chebyshev_weights(double largest, int steps);

/// Ratio of the largest to the smallest eigenvalue of an elasticity matrix in Voigt notation.
double stiffness_contrast(const Matrix6& stiffness);
/// Steps that suffice where volume changes and shears are about equally stiff.
constexpr int steps_of_low_contrast = 2;
/// Steps before and after a coarse correction. Near incompressibility and with stiff fibres, relaxation has a
/// wider range to damp. Measured for the shortest time to 1e-3.
int relaxation_steps(double contrast);

/// Start of the eigenvalue iteration: a right-hand side of -1 or 1 in units of the diagonal, the same on
/// every machine. The obvious version of noise_entries (masked_kernel.hpp).
/// @param i entry; @param inverse of its diagonal, 0 where it is fixed
float eigenvalue_noise(std::size_t i, float inverse);
/// Upper estimate of the largest eigenvalue of inverse diagonal times operator, from ten steps of conjugate
/// gradients preconditioned by the diagonal.
///
/// Source  Lanczos' tridiagonal matrix: Saad, Iterative Methods for Sparse Linear Systems, 2003, section
///         6.7.3
double largest_eigenvalue_seen_by(GradientSpace& space);

} // namespace maille::deform
