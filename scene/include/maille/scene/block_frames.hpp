#pragma once
/// Cells at finite strain: the frame that turns with each, and the response of its matter.
///
/// F = I + grad u is the mean deformation gradient of a cell, R the rotation nearest to it (polar
/// decomposition), U = R^T F. Strain and limits are measured on U - I, Biot's strain, so that a turned cell
/// is not strained. E = (F^T F - I) / 2 is Green and Lagrange's, of which the material's law gives energy and
/// stress. Strains out of the scene's directions are 0 in plane strain, and such that their stress is 0 in
/// plane stress and in 1D.

#include "maille/scene/answer.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

namespace maille {

/// True if the scene asks for finite strain, and cells can turn: in 1D they cannot.
inline bool in_blocks(const Scene& scene) {
  return scene.strain == Strain::finite && scene.dimension() > 1;
}

/// The matter of a cell.
struct CellMatter {
  const Material& material;
  const Matrix6& stiffness; ///< for small strains, object's frame; the law's where it has none [Pa]
  Eigen::Vector3d fibre;    ///< unit vector, object's frame at rest
  double tension = 0;       ///< active stress: pulls along the fibre, per area at rest [Pa]
};
/// Energy, stress S and tangent of matter at a strain, the fibre's pull included: its energy is tension (l -
/// 1), with l the stretch of the fibre.
/// @param E Green and Lagrange's; C = I + 2 E is positive definite. Strains that are free become those found
/// @param active part of the energy that is the fibre's pull, which the response's energy leaves out [Pa]
/// Errors  E may be so far out that no free strains are found: then the stress out of the plane is not zero
LawResponse respond(const CellMatter& matter, int dimension, PlaneAssumption plane, Eigen::Matrix3d& E,
                    double& active);

/// Voigt order 11, 22, 33, 23, 13, 12, engineering shears in strains.
Eigen::Matrix3d as_stress(const Vector6& v);
Eigen::Matrix3d as_strain(const Vector6& v);
Vector6 stress_of(const Eigen::Matrix3d& symmetric);
/// The strain of the symmetric part.
Vector6 strain_of(const Eigen::Matrix3d& matrix);

/// The mean displacement gradient of a cell [component][axis], from its corners [1]; zero outside of the
/// scene's dimension.
Eigen::Matrix3d displacement_gradient(const Grid& grid, const Displacement& displacement, const Index3& cell);

/// The rotation of every cell of matter, nearest to I + displacement_gradient; without turn elsewhere. By
/// cell.
/// Cost  O(cells), a quarter to one microsecond each
List<Eigen::Quaterniond> block_rotations(const Scene& scene, const Displacement& displacement);

/// The largest amount by which a link breaks its limits in the mean frame of the cells that it borders, in
/// units of its rest length; 0 if none does.
double largest_violation_in_blocks(const Scene& scene, const LinkLimits& limits,
                                   const Displacement& displacement);

/// The rotation R nearest to F in the sum of squares, which makes R^T F symmetric (the polar decomposition,
/// for matter that is not turned inside out). Where several are as near as each other, one of them.
///
/// Newton steps on the turn that is left, from `guess`: two to four where the guess is near; the singular
/// values of F otherwise.
/// @param dimension 2: about z, from the upper left 2 x 2 of F alone; 3
/// @param guess unit; the result is right to rounding wherever it begins
/// Source  Higham 1986 (SIAM J. Sci. Stat. Comput. 7) for the polar decomposition; the step is that of tr(R^T
///         F), whose only local maximum on rotations is the global one
Eigen::Quaterniond nearest_rotation(int dimension, const Eigen::Matrix3d& F, const Eigen::Quaterniond& guess);

/// The mean of rotations less than half a turn apart.
class MeanRotation {
public:
  void add(const Eigen::Quaterniond& q) {
    sum_.coeffs() += sum_.dot(q) < 0 ? Eigen::Vector4d(-q.coeffs()) : q.coeffs();
  }
  /// The identity before any was added.
  Eigen::Quaterniond value() const {
    return sum_.squaredNorm() > 0 ? sum_.normalized() : Eigen::Quaterniond::Identity();
  }

private:
  Eigen::Quaterniond sum_{0, 0, 0, 0};
};

} // namespace maille
