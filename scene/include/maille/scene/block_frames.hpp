#pragma once
/// Cells at finite strain: the rotating frame of each cell, and the response of its matter.
///
/// F = I + grad u is the mean deformation gradient of a cell, R the rotation nearest to it (polar
/// decomposition), U = R^T F. Strain and limits are measured on U - I, Biot's strain, so that a rotated cell
/// is not strained. E = (F^T F - I) / 2 is the Green-Lagrange strain, which the material's law maps to energy
/// and stress. Strains outside the scene's dimensions are 0 in plane strain; in plane stress and 1D they
/// follow from zero stress.

#include "maille/scene/answer.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

namespace maille {

/// True at finite strain in 2D and 3D. In 1D cells cannot rotate.
inline bool in_blocks(const Scene& scene) {
  return scene.strain == Strain::finite && scene.dimension() > 1;
}

/// The matter of a cell.
struct CellMatter {
  const Material& material;
  const Matrix6& stiffness; ///< for small strains, object's frame; used if the material has no law [Pa]
  Eigen::Vector3d fibre;    ///< unit vector, object's frame at rest
  double tension = 0;       ///< active stress along the fibre, per area at rest [Pa]
};
/// Energy, stress S and tangent of matter at a strain, including active stress, whose energy is tension (l -
/// 1), with l the stretch of the fibre.
/// @param E Green-Lagrange strain; C = I + 2 E is positive definite. On return, free strains are set
/// @param active energy of the active stress, which the response's energy excludes [Pa]
/// Errors  for extreme E no free strains may be found; then the stress out of the plane is not zero
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

/// The rotation of every cell of matter, nearest to I + displacement_gradient; the identity elsewhere.
/// Indexed by cell.
/// Cost  O(cells), a quarter to one microsecond each
List<Eigen::Quaterniond> block_rotations(const Scene& scene, const Displacement& displacement);

/// Largest violation of a link's limits in the mean frame of its cells, relative to its rest length; 0 if all
/// limits hold.
double largest_violation_in_blocks(const Scene& scene, const LinkLimits& limits,
                                   const Displacement& displacement);

/// The rotation R nearest to F in the least-squares sense, which makes R^T F symmetric (the polar
/// decomposition, for matter that is not inverted). One of them if several are equally near.
///
/// Newton steps on the remaining rotation, from `guess`: two to four if the guess is near; else the singular
/// value decomposition of F.
/// @param dimension 2: about z, from the upper left 2 x 2 block of F; 3
/// @param guess unit quaternion; the result is accurate to rounding for any guess
/// Source  Higham 1986 (SIAM J. Sci. Stat. Comput. 7) for the polar decomposition; the step is that of tr(R^T
///         F), whose only local maximum on rotations is the global one
Eigen::Quaterniond nearest_rotation(int dimension, const Eigen::Matrix3d& F, const Eigen::Quaterniond& guess);

/// The mean of rotations less than half a turn apart.
class MeanRotation {
public:
  void add(const Eigen::Quaterniond& q) {
    sum_.coeffs() += sum_.dot(q) < 0 ? Eigen::Vector4d(-q.coeffs()) : q.coeffs();
  }
  /// The identity if none was added.
  Eigen::Quaterniond value() const {
    return sum_.squaredNorm() > 0 ? sum_.normalized() : Eigen::Quaterniond::Identity();
  }

private:
  Eigen::Quaterniond sum_{0, 0, 0, 0};
};

} // namespace maille
