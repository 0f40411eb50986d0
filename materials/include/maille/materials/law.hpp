#pragma once
/// Large-strain laws of matter: energy, stress and tangent of a point from its Green-Lagrange strain.
///
/// F is the deformation gradient, C = F^T F, E = (C - I) / 2, J = det F, f the unit fibre at rest. A law is an
/// energy W(E, f) per volume at rest. Its stress is S = dW/dE, the second Piola-Kirchhoff stress; P = F S is
/// nominal and F S F^T / J Cauchy's. Its tangent is dS/dE. All of them are in the frame of E, in Voigt order
/// 11, 22, 33, 23, 13, 12 with engineering shears in E. Names of parameters are those of FEBio.
///
/// Exact: closed forms, no differences. At rest every law has stress 0, and the tangent is the stiffness of
/// its own linear material (rest_constants). All laws are transversely isotropic about f, or isotropic.

#include "maille/materials/elasticity.hpp"

#include <Eigen/Core>

#include <variant>

namespace maille {

/// W = mu / 2 (tr C - 3) - mu ln J + lambda / 2 (ln J)^2; E and nu as in linear elasticity.
/// Source  Bonet and Wood 2008, Nonlinear Continuum Mechanics, eq. 6.27; FEBio `neo-Hookean`
struct NeoHookean {
  double mu = 0, lambda = 0; ///< [Pa]; mu > 0, lambda > -2/3 mu
};

/// What a law answers at a strain.
struct LawResponse {
  double energy = 0;                 ///< per volume at rest [Pa]
  Vector6 stress = Vector6::Zero();  ///< S [Pa]
  Matrix6 tangent = Matrix6::Zero(); ///< dS/dE [Pa]
};

using Law = std::variant<NeoHookean>;

/// @param E Green-Lagrange strain; C = I + 2 E is positive definite @param fibre unit vector
LawResponse respond(const Law& law, const Eigen::Matrix3d& E, const Eigen::Vector3d& fibre);
/// Linear elasticity in a frame that turns with the matter: W = 1/2 (U - I) : stiffness : (U - I), with
/// U = sqrt(C); the law of a material without one.
/// Source  Chao, Pinkall, Sanan, Schroeder 2010 (ACM TOG 29), for any stiffness
LawResponse respond_corotated(const Matrix6& stiffness, const Eigen::Matrix3d& E);

/// The linear material that a law is at rest; axis 1 is the fibre.
ElasticConstants rest_constants(const Law& law);

} // namespace maille
