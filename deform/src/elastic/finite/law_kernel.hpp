#pragma once
/// Energy, forces and tangent of neo-Hookean cells in 3D, a vector of cells at a time.
///
/// By the deformation gradient F alone: with G = F^-T and L = ln det F, neo-Hookean matter has
///
///   W = mu / 2 (tr C - 3) - mu L + lambda / 2 L^2,  P = mu F + (lambda L - mu) G,
///   dP = mu dF + lambda (G : dF) G + (mu - q) G dF^T G,  q = (lambda - kappa) L and the pressure.
///
/// and corotated matter, with F = R U and B = U - I,
///
///   W = mu B : B + lambda / 2 (tr B)^2,  P = R (2 mu B + lambda tr B),
///   dP = 2 mu dF + lambda (R : dF) R - (2 mu - lambda tr B) R Omega - (pressure - kappa L) G dF^T G,
///
/// where Omega = R^T dR is the turn about (tr U - U)^-1 axl(R^T dF - dF^T R).
///
/// What lies beyond F is as in FiniteElasticity. The same bits for vectors of any length of one kind.
/// It saves half the time of a box of 64^3 corotated cells, a third of neo-Hookean ones.
///
/// Source  materials/law.hpp, FiniteElasticity
/// Checked by  tests/deform/elastic/finite_elasticity_test.cpp, against the scalar law

#include "elastic/finite/tangent_kernel.hpp"

namespace maille::deform {

/// Cells of one kind of matter, lattice_kernel's most_cells at most. Arrays are by cell.
struct LawRun : TangentRun {
  bool is_corotated = false;            ///< else neo-Hookean
  double mu = 0, lambda = 0, kappa = 0; ///< [Pa]
  double volume = 0;                    ///< [m^3]
  const double* weight = nullptr;       ///< [1]
  const double* beyond = nullptr;       ///< K by pairs [N/m]
  double* determinant = nullptr;        ///< of F
  double* energy = nullptr;             ///< [J]
  float* found = nullptr;               ///< TangentRun's numbers
  double* pressure = nullptr;           ///< [Pa]
  double* volume_pressure = nullptr;    ///< kappa L [Pa]
  bool has_pressures = false;           ///< else they become kappa L
  bool is_exact = true;                 ///< else without what lies beyond F
  double least_part = 0; ///< of the diagonal's largest entry: what an eigenvalue may be below 0
};

/// forces += the gradient of the energy; fills in determinant and energy, which counts where the determinant
/// is positive.
void evaluate_law(const LawRun& run);
/// Fills in numbers, pressures and, unless it is exact, determinant: positive where the tangent has no
/// eigenvalue below the least part.
void linearise_law(const LawRun& run);

} // namespace maille::deform
