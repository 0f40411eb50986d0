#pragma once
/// Chebyshev relaxation: Jacobi steps whose weights make a Chebyshev polynomial, and the eigenvalues that
/// they need.
///
/// Scheme: step k is u += w_k D^-1 (f - A u), D the diagonal of A. The product of the error factors (1 - w_k
/// x) is small for all eigenvalues x of D^-1 A from a lower end to `largest`; coarser levels correct the
/// others.
///
/// Exact: the weights for a given range. Heuristic: the range's lower end, the number of steps by the
/// contrast of the stiffness, and a margin on an eigenvalue that conjugate gradients approach from below.

#include "elastic/krylov/conjugate_gradients.hpp"
#include "maille/materials/elasticity.hpp"

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

/// Upper estimate of the largest eigenvalue of inverse diagonal times operator, from ten steps of conjugate
/// gradients preconditioned by the diagonal.
///
/// Source  Lanczos' tridiagonal matrix: Saad, Iterative Methods for Sparse Linear Systems, 2003, section
///         6.7.3
double largest_eigenvalue_seen_by(GradientSpace& space);

} // namespace maille::deform
