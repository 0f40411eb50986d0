#pragma once
/// Energy of matter at a point of large strain, with its stress and tangent by automatic differentiation.
///
/// F is the deformation gradient, f the unit fibre at rest, J = det F. A law is written as its energy W(F, f)
/// per volume at rest, and as nothing else: Sacado's nested forward numbers give dW and d2W by the 9 entries
/// of F and by the dilatation theta. materials/src/law.cpp has the same laws as closed forms of stress and
/// tangent; the two share no formula, and tests hold one against the other.
///
/// Near incompressibility elements lock unless a smooth dilatation theta stands for J: the energy is
/// W((theta / J)^(1/3) F) + G/2 ln^2(theta / J), exact where theta = J. The second term, G the shear modulus
/// at rest, holds J to theta between the modes of theta. Without it a block of quadratic elements buckles
/// cell by cell at a stretch of 0.67, with it as halfspaces do, at 0.5.
/// Source  Simo, Taylor, Pister 1985 (Comput. Methods Appl. Mech. Eng. 51); Phipps, Pawlowski 2012 (Sacado)

#include "maille/scene/scene.hpp"

#include <Eigen/Core>

#include <optional>

namespace maille::fem_ref {

/// What a cell is made of.
struct Matter {
  const Law* law = nullptr;            ///< none: linear elasticity of U - I, U = sqrt(F^T F)
  Matrix6 stiffness = Matrix6::Zero(); ///< of that, object's frame [Pa]
  Eigen::Vector3d fibre{1, 0, 0};      ///< unit vector
  double shear = 0;                    ///< G [Pa]
  double weight = 1;                   ///< on the energy of law or stiffness
  double tension = 0;                  ///< energy tension (|F f| - 1) of contracting fibres [Pa]
};
Matter matter_of(const Scene& scene, std::int64_t cell);

/// Entries of F by rows, then theta.
constexpr int n_point_inputs = 10;

struct PointResponse {
  double strain_energy = 0;                                      ///< without that of contracting fibres [Pa]
  Eigen::Matrix<double, n_point_inputs, 1> gradient;             ///< of all energy [Pa]
  Eigen::Matrix<double, n_point_inputs, n_point_inputs> hessian; ///< the same
};

/// @param F with det F > 0 @param theta > 0; none: J, and the entries of theta are 0
/// Cost  5 us for neo-Hookean, 40 us without a law
PointResponse respond_at(const Matter& matter, const Eigen::Matrix3d& F, std::optional<double> theta);

} // namespace maille::fem_ref
