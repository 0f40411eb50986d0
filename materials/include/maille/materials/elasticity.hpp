#pragma once
/// Linear elasticity at a point: constants, stiffness, rotation, reduction to 1D and 2D.
///
/// Voigt order is 11, 22, 33, 23, 13, 12 with engineering shear strains (gamma = 2 eps), everywhere in
/// Maille except in VTK files. Axis 1 of a material is its fibre.

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

namespace maille {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Nine orthotropic constants in the material frame; isotropy and transverse isotropy are special cases.
/// nu_ij is the contraction along j under tension along i, so nu_ij / E_i = nu_ji / E_j.
struct ElasticConstants {
  std::array<double, 3> youngs_modulus{}; ///< E_1, E_2, E_3 [Pa], > 0
  double nu12 = 0, nu13 = 0, nu23 = 0;    ///< Poisson ratios [1]
  double G12 = 0, G13 = 0, G23 = 0;       ///< shear moduli [Pa], > 0

  /// E > 0 [Pa], -1 < nu < 0.5.
  static ElasticConstants isotropic(double youngs_modulus, double poisson_ratio);
  /// Fibre = axis 1. G_cross follows: E_cross / (2 (1 + nu_cross)).
  static ElasticConstants transversely_isotropic(double E_fibre, double E_cross, double G_fibre,
                                                 double nu_fibre, double nu_cross);
  /// True if rotation does not change the material (to 1e-12 relative).
  bool is_isotropic() const;
};

/// Violated inequalities for positive strain energy (Lempriere 1968), each with its numbers, e.g. `|nu12| <
/// sqrt(E1/E2)  (0.9 < 0.5)`; empty for a valid material.
std::vector<std::string> violated_inequalities(const ElasticConstants& constants);

/// 6 x 6 compliance S in the material frame [1/Pa]: strain = S stress.
Matrix6 compliance(const ElasticConstants& constants);
/// 6 x 6 stiffness C = S^-1 in the material frame [Pa].
/// @pre violated_inequalities(constants) is empty
Matrix6 stiffness(const ElasticConstants& constants);

/// Right-handed axes (columns, in the object's frame) with first axis `fibre`: the smallest rotation from e_x
/// to the fibre; for fibre = -e_x the half turn about e_z.
/// @param fibre any length > 0
Eigen::Matrix3d axes_from_fibre(const Eigen::Vector3d& fibre);

/// The stiffness `C` of a material whose axes are the columns of `axes`, in the object's frame.
/// Source: Bond 1943, the 6 x 6 stress transformation M: C' = M C M^T.
Matrix6 turned(const Matrix6& C, const Eigen::Matrix3d& axes);
/// The same for a compliance: S' = M^-T S M^-1.
Matrix6 turned_compliance(const Matrix6& S, const Eigen::Matrix3d& axes);

/// Assumption for the third direction of a plane scene.
enum class PlaneAssumption { strain, stress };

/// The stiffness for a scene of `dimension` 1, 2 or 3: a 1 x 1 (uniaxial stress: 1 / S_11), 3 x 3 (order xx,
/// yy, xy; plane strain or plane stress) or 6 x 6 matrix of the rotated `C` [Pa].
Eigen::MatrixXd reduced_stiffness(const Matrix6& C, int dimension, PlaneAssumption plane);

/// Poisson ratios nu12, nu13, nu23 for these moduli and this bulk modulus K at which pressure changes the
/// size of the material but not its shape: every row of the 3 x 3 block of the compliance has the sum 1 / (3
/// K). Isotropic: 1/2 - E / (6 K). Transversely isotropic: nu_fibre = 1/2 - E_fibre / (6 K), nu_cross = 1 -
/// E_cross (nu_fibre / E_fibre + 1 / (3 K)). Not every K gives a valid material: see violated_inequalities.
/// @param youngs_modulus E_1, E_2, E_3 [Pa], > 0; @param bulk_modulus [Pa], > 0
std::array<double, 3> poisson_ratios_at(const std::array<double, 3>& youngs_modulus, double bulk_modulus);

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Adds the free lateral strains to `strain`: those at which the stress C strain + active is zero in the free
/// directions (1D: all but the first; plane stress: those out of the plane; else none). Voigt order 11 22 33
/// 23 13 12, engineering shear.
void release_free_directions(const Matrix6& C, const Vector6& active, int dimension, PlaneAssumption plane,
                             Vector6& strain);

} // namespace maille
