#pragma once
/// The rotation in a deformation gradient.

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace maille {

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
