#pragma once
/// Frames that turn with every cell (`frame = "blocks"`), for bodies that bend.
///
/// F = I + grad u is the mean deformation gradient of a cell, R the rotation nearest to it (polar
/// decomposition). Strain and limits are then measured on R^T F - I, Biot's strain, so that a turned cell is
/// not strained. The rotation is exact to rounding; the strain is still a linear law on it.

#include "maille/scene/answer.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

namespace maille {

/// True if the scene asks for them: in 1D there is nothing to turn.
inline bool in_blocks(const Scene& scene) {
  return scene.strain == Strain::finite && scene.dimension() > 1;
}

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
