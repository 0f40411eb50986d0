#include "maille/scene/block_frames.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>

#include <cmath>

namespace maille {

namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr int most_steps = 12;
/// Remaining rotation below which the next step is at rounding level [rad].
constexpr double settled = 1e-8;

Quaterniond in_plane(const Matrix3d& F) {
  const double half = 0.5 * std::atan2(F(1, 0) - F(0, 1), F(0, 0) + F(1, 1));
  return {std::cos(half), 0, 0, std::sin(half)};
}

Quaterniond by_singular_values(const Matrix3d& F) {
  const Eigen::JacobiSVD<Matrix3d> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return Quaterniond(Matrix3d(svd.matrixU() * Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose()));
}

} // namespace

Quaterniond nearest_rotation(int dimension, const Matrix3d& F, const Quaterniond& guess) {
  if (dimension == 2)
    return in_plane(F);
  Quaterniond q = guess;
  for (int step = 0; step < most_steps; ++step) {
    const Matrix3d A = q.toRotationMatrix().transpose() * F;
    const Vector3d skew(A(2, 1) - A(1, 2), A(0, 2) - A(2, 0), A(1, 0) - A(0, 1));
    const Matrix3d H = A.trace() * Matrix3d::Identity() - 0.5 * (A + A.transpose());
    // Maximum of tr(R^T F) only if H is positive definite; do not step from a minimum.
    const double minor = H(0, 0) * H(1, 1) - H(0, 1) * H(0, 1), determinant = H.determinant();
    const double size = H.trace();
    if (!(H(0, 0) > 0 && minor > 0 && determinant > 1e-6 * size * size * size))
      break;
    const Vector3d left = H.inverse() * skew;
    const double angle = left.norm();
    if (angle > 2)
      break;
    q = (q * Quaterniond(1, 0.5 * left[0], 0.5 * left[1], 0.5 * left[2])).normalized();
    if (angle < settled)
      return q;
  }
  return by_singular_values(F);
}

} // namespace maille
