#pragma once
/// Large-strain material laws: energy, stress and tangent at a point from its Green-Lagrange strain.
///
/// F is the deformation gradient, C = F^T F, E = (C - I) / 2, J = det F, f the unit fibre at rest. A law is
/// an energy W(E, f) per volume at rest. Its stress is S = dW/dE, the second Piola-Kirchhoff stress; P = F S
/// is nominal and F S F^T / J the Cauchy stress. Its tangent is dS/dE. All are in the frame of E, in Voigt
/// order 11, 22, 33, 23, 13, 12 with engineering shears in E. Parameters have the names of FEBio.
///
/// Exact: closed forms, no finite differences. At rest the stress is 0 (except for an active muscle), and the
/// tangent is the stiffness of the law's own linear material (rest_constants). A law is isotropic or
/// transversely isotropic about f.
///
/// Invariants: I1 = tr C, I2 = (I1^2 - tr C^2) / 2, I4 = f.C f, I5 = f.C^2 f; I1~ = J^-2/3 I1,
/// I2~ = J^-4/3 I2, I4~ = J^-2/3 I4, I5~ = J^-4/3 I5 are independent of volume changes.

#include "maille/materials/elasticity.hpp"

#include <Eigen/Core>

#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace maille {

/// W = mu / 2 (tr C - 3) - mu ln J + lambda / 2 (ln J)^2; E and nu as in linear elasticity.
/// Source  Bonet and Wood 2008, Nonlinear Continuum Mechanics, eq. 6.27; FEBio `neo-Hookean`
struct NeoHookean {
  double mu = 0, lambda = 0; ///< [Pa]; mu > 0, lambda > -2/3 mu

  friend bool operator==(const NeoHookean&, const NeoHookean&) = default;
};

/// W = c1 (I1~ - 3) + c2 (I2~ - 3) + k/2 (ln J)^2; the shear modulus at rest is 2 (c1 + c2).
/// Source  Mooney 1940, J. Appl. Phys. 11:582; Rivlin 1948; FEBio `Mooney-Rivlin`
struct MooneyRivlin {
  double c1 = 0, c2 = 0; ///< [Pa]; c1 > 0, c2 >= 0
  double k = 0;          ///< bulk modulus [Pa], > 0

  friend bool operator==(const MooneyRivlin&, const MooneyRivlin&) = default;
};

/// W = C/2 (e^Q - 1) + k/2 (ln J)^2 with axis 1 the fibre,
/// Q = bf E11^2 + bt (E22^2 + E33^2 + 2 E23^2) + 2 bfs (E12^2 + E13^2).
/// E is not split into volume and shape: split fibre laws let tissue swell under tension.
/// Source  Guccione, McCulloch, Waldman 1991, J. Biomech. Eng. 113:42; Land and others 2015, Proc. R. Soc. A
///         471:20150641; whole E: Weickenmeier 2014, doi 10.1002/cnm.2618
struct Guccione {
  double C = 0;                   ///< [Pa], > 0
  double bf = 0, bt = 0, bfs = 0; ///< along the fibre, across, shear [1], > 0
  double k = 0;                   ///< bulk modulus [Pa], > 0

  friend bool operator==(const Guccione&, const Guccione&) = default;
};

/// W = c/2 (I1~ - 3) + k1 / (2 k2) (exp(k2 <A>^2) - 1) + k/2 ((J^2 - 1) / 2 - ln J), <A> = max(A, 0),
/// A = kappa (I1~ - 3) + (1 - 3 kappa) (I4~ - 1): one family of fibres, in tension only. At A = 0 the tangent
/// is that of tension.
/// Source  Gasser, Ogden, Holzapfel 2006, J. R. Soc. Interface 3:15; FEBio `Holzapfel-Gasser-Ogden`
struct HolzapfelGasserOgden {
  double c = 0;     ///< shear modulus of the matrix [Pa], > 0
  double k1 = 0;    ///< stiffness of the fibres [Pa], >= 0
  double k2 = 0;    ///< growth of that stiffness [1], > 0
  double kappa = 0; ///< spread of the fibres, 0 (parallel) to 1/3 (all directions alike)
  double k = 0;     ///< bulk modulus [Pa], > 0

  friend bool operator==(const HolzapfelGasserOgden&, const HolzapfelGasserOgden&) = default;
};

/// W = g1 B1^2 + g2 B2^2 + 9/4 g3 s^2 + smax (P(r) + activation A(r)) + k/2 (ln J)^2, with
/// B1^2 = I5 / I4^2 - 1 (shear along the fibre), cosh B2 = (I1~ I4~ - I5~) / (2 sqrt I4~) (shear across),
/// s = ln sqrt I4~, r = sqrt I4~ / Lofl, and the fibre's forces
///
///   P' = 0 up to r = 1, then p1 (exp(p2 (r - 1)) - 1), linear from r = lam_max / Lofl;
///   A' = 1 - 4 (r - 1)^2 up to |r - 1| = 0.4, then 9 (|r - 1| - 0.6)^2, and 0 from 0.6.
///
/// g3 is FEBio's addition: without it a fibre shorter than Lofl has no stiffness of its own.
/// Source  Blemker, Pinsky, Delp 2005, J. Biomech. 38:657; FEBio `muscle material`
struct Muscle {
  double g1 = 0, g2 = 0;           ///< half the shear moduli along and across the fibre [Pa], > 0
  double p1 = 0, p2 = 0;           ///< passive force: factor and growth [1], >= 0, > 0
  double Lofl = 1;                 ///< stretch at which the active force peaks, >= 1
  double lam_max = 1;              ///< stretch from which the passive force is linear, >= Lofl
  double smax = 0, activation = 0; ///< peak active stress [Pa], >= 0; 0 (passive) to 1
  double k = 0;                    ///< bulk modulus [Pa], > 0
  double g3 = 0;                   ///< stiffness along the fibre [Pa], > 0; 4/3 g1 as in isotropic matter

  friend bool operator==(const Muscle&, const Muscle&) = default;
};

/// Energy, stress and tangent of a law at a strain.
struct LawResponse {
  double energy = 0;                 ///< per volume at rest [Pa]; infinite on overflow
  Vector6 stress = Vector6::Zero();  ///< S [Pa]; undefined at infinite energy
  Matrix6 tangent = Matrix6::Zero(); ///< dS/dE [Pa]; undefined at infinite energy
};

using Law = std::variant<NeoHookean, MooneyRivlin, Guccione, HolzapfelGasserOgden, Muscle>;

/// @param E Green-Lagrange strain; C = I + 2 E is positive definite @param fibre unit vector
LawResponse respond(const Law& law, const Eigen::Matrix3d& E, const Eigen::Vector3d& fibre);
/// Linear elasticity in a frame that turns with the matter: W = 1/2 (U - I) : stiffness : (U - I), with
/// U = sqrt(C); the law of a material without one.
/// Source  Chao, Pinkall, Sanan, Schroeder 2010 (ACM TOG 29), for any stiffness
LawResponse respond_corotated(const Matrix6& stiffness, const Eigen::Matrix3d& E);

/// The linear material of a law at rest (for a muscle: passive); axis 1 is the fibre.
ElasticConstants rest_constants(const Law& law);
/// True if the law does not depend on the fibre.
bool is_isotropic(const Law& law);
/// Name of a law in a scene file: "mooney_rivlin".
std::string_view name_of(const Law& law);
/// Name of each parameter and pointer into `law`, which must outlive them.
std::vector<std::pair<std::string_view, double*>> parameters(Law& law);

} // namespace maille
