#pragma once
/// Algebra of a cell's tangent: from the stress of a law to the derivative of its nominal stress.
///
/// F is the deformation gradient, S(E) the second Piola-Kirchhoff stress with its tangent dS/dE, P = F S the
/// nominal stress. Matrices of 3 x 3 are vectors of nine by columns.
///
/// Exact: dP = dF S + F dS. Heuristic: make_positive(), which replaces the tangent by a descent direction far
/// from the minimum.

#include "maille/scene/block_frames.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <array>
#include <cmath>

namespace maille::deform {

using Matrix9d = Eigen::Matrix<double, 9, 9>;

/// Voigt index of a pair of axes.
inline constexpr std::array<std::array<int, 3>, 3> voigt{{{0, 5, 4}, {5, 1, 3}, {4, 3, 2}}};

/// Adds a pressure to stress and tangent: A = C^-1, and its derivative by E, -(A_ik A_jl + A_il A_jk).
inline void shift_pressure(double shift, const Eigen::Matrix3d& F, LawResponse& response) {
  if (shift == 0)
    return;
  const Eigen::Matrix3d A = (F.transpose() * F).inverse();
  response.stress += shift * stress_of(A);
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j)
      for (int k = 0; k < 3; ++k)
        for (int l = k; l < 3; ++l)
          response.tangent(voigt[i][j], voigt[k][l]) -= shift * (A(i, k) * A(j, l) + A(i, l) * A(j, k));
}

/// dP/dF of P = F S(E): dP = dF S + F dS. F_bM changes E_Ma by F_bM where dF is at (b, a).
inline Matrix9d tangent_of_gradient(const Eigen::Matrix3d& F, const LawResponse& response) {
  Matrix9d A;
  const Eigen::Matrix3d S = as_stress(response.stress);
  for (int c = 0; c < 3; ++c)
    for (int e = 0; e < 3; ++e) {
      Vector6 dS = Vector6::Zero();
      for (int N = 0; N < 3; ++N)
        dS += F(e, N) * response.tangent.col(voigt[c][N]);
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b)
          A(3 * a + b, 3 * c + e) = F(b, 0) * dS[voigt[a][0]] + F(b, 1) * dS[voigt[a][1]] +
                                    F(b, 2) * dS[voigt[a][2]] + (b == e ? S(a, c) : 0);
    }
  return A;
}

/// Raises eigenvalues below `least_part` of the largest entry to the size of that part.
template<int n>
void make_positive(double least_part, Eigen::Matrix<double, n, n>& A) {
  using Matrix = Eigen::Matrix<double, n, n>;
  const double least = least_part * A.diagonal().cwiseAbs().maxCoeff();
  if ((A - least * Matrix::Identity()).llt().info() == Eigen::Success)
    return;
  const Eigen::SelfAdjointEigenSolver<Matrix> principal(A);
  A = principal.eigenvectors() * principal.eigenvalues().cwiseMax(std::abs(least)).asDiagonal() *
      principal.eigenvectors().transpose();
}

} // namespace maille::deform
