#pragma once
/// Energy density at a point of large strain, with its stress and tangent by automatic differentiation.
///
/// F is the deformation gradient, f the unit fibre at rest, J = det F. A law is defined only by its energy
/// W(F, f) per volume at rest: Sacado's nested forward numbers give dW and d2W by the 9 entries of F and by
/// the dilatation theta. materials/src/law.cpp has the same laws as closed forms of stress and tangent; the
/// two share no formula, and tests compare them.
///
/// Near incompressibility elements lock. A smooth dilatation theta in place of J avoids this: the energy is
/// W((theta / J)^(1/3) F) + G/2 ln^2(theta / J), exact for theta = J. The second term, with G the shear
/// modulus at rest, ties J to theta between the modes of theta. Without it a block of quadratic elements
/// buckles cell by cell at a stretch of 0.67; with it at 0.5, the value of a halfspace.
/// Source  Simo, Taylor, Pister 1985 (Comput. Methods Appl. Mech. Eng. 51); Phipps, Pawlowski 2012 (Sacado)

#include "maille/scene/scene.hpp"

#include <Eigen/Core>

#include <optional>

namespace maille::fem_ref {

/// Material of a cell.
struct Matter {
  const Law* law = nullptr;            ///< none: linear elasticity of U - I, U = sqrt(F^T F)
  Matrix6 stiffness = Matrix6::Zero(); ///< of linear elasticity, object's frame [Pa]
  Eigen::Vector3d fibre{1, 0, 0};      ///< unit vector
  double shear = 0;                    ///< G [Pa]
  double weight = 1;                   ///< factor on the energy of law or stiffness
  double tension = 0;                  ///< energy tension (|F f| - 1) of contracting fibres [Pa]
};
Matter matter_of(const Scene& scene, std::int64_t cell);

/// Entries of F by rows, then theta.
constexpr int n_point_inputs = 10;

struct PointResponse {
  double strain_energy = 0;                                      ///< without contracting fibres [Pa]
  Eigen::Matrix<double, n_point_inputs, 1> gradient;             ///< of the total energy [Pa]
  Eigen::Matrix<double, n_point_inputs, n_point_inputs> hessian; ///< of the total energy [Pa]
};

/// @param F with det F > 0 @param theta > 0; none: J is used, and the entries of theta are 0
/// Cost  5 us for neo-Hookean, 40 us without a law
PointResponse respond_at(const Matter& matter, const Eigen::Matrix3d& F, std::optional<double> theta);

} // namespace maille::fem_ref
