#include "maille/materials/law.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <array>
#include <cmath>

namespace maille {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Axes of the entries of Voigt order.
constexpr std::array<std::array<int, 2>, 6> voigt_axes{{{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}};

/// A symmetric tensor as a stress: shears count once.
Vector6 to_voigt(const Matrix3d& of) {
  Vector6 v;
  for (int p = 0; p < 6; ++p)
    v[p] = of(voigt_axes[p][0], voigt_axes[p][1]);
  return v;
}

/// d(C^-1)/dE = -2 A (.) A with A = C^-1, (A (.) A)_ijkl = (A_ik A_jl + A_il A_jk) / 2.
Matrix6 derivative_of_inverse(const Matrix3d& A) {
  Matrix6 D;
  for (int p = 0; p < 6; ++p)
    for (int q = p; q < 6; ++q) {
      const auto [i, j] = voigt_axes[p];
      const auto [k, l] = voigt_axes[q];
      D(p, q) = D(q, p) = -(A(i, k) * A(j, l) + A(i, l) * A(j, k));
    }
  return D;
}

/// What every law needs of C = I + 2 E.
struct Stretched {
  Matrix3d inverse; ///< of C
  double log_J;     ///< with all its digits at small strains

  explicit Stretched(const Matrix3d& E) {
    inverse = (Matrix3d::Identity() + 2 * E).inverse();
    const double minors = E(0, 0) * E(1, 1) - E(0, 1) * E(1, 0) + E(0, 0) * E(2, 2) - E(0, 2) * E(2, 0) +
                          E(1, 1) * E(2, 2) - E(1, 2) * E(2, 1);
    log_J = 0.5 * std::log1p(2 * E.trace() + 4 * minors + 8 * E.determinant());
  }
};

LawResponse respond(const NeoHookean& law, const Matrix3d& E, const Vector3d&) {
  const Stretched at(E);
  LawResponse response;
  const double pressure = law.lambda * at.log_J - law.mu;
  const Vector6 inverse = to_voigt(at.inverse);
  response.energy = law.mu * (E.trace() - at.log_J) + 0.5 * law.lambda * at.log_J * at.log_J;
  response.stress = pressure * inverse;
  response.stress.head<3>().array() += law.mu;
  response.tangent =
      law.lambda * inverse * inverse.transpose() + pressure * derivative_of_inverse(at.inverse);
  return response;
}

ElasticConstants rest_constants(const NeoHookean& law) {
  const double nu = law.lambda / (2 * (law.lambda + law.mu));
  return ElasticConstants::isotropic(2 * law.mu * (1 + nu), nu);
}

} // namespace

LawResponse respond(const Law& law, const Matrix3d& E, const Vector3d& fibre) {
  return std::visit([&](const auto& of) { return respond(of, E, fibre); }, law);
}

ElasticConstants rest_constants(const Law& law) {
  return std::visit([](const auto& of) { return rest_constants(of); }, law);
}

/// S follows from U S + S U = 2 T with T = stiffness (U - I), since T : dU = S : dE and dC = U dU + dU U. In
/// the principal frame of U these equations have one unknown each.
LawResponse respond_corotated(const Matrix6& stiffness, const Matrix3d& E) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> principal(E);
  const Matrix3d& Q = principal.eigenvectors();
  const Vector3d stretch = (1 + 2 * principal.eigenvalues().array()).sqrt(),
                 strain = 2 * principal.eigenvalues().array() / (1 + stretch.array()); // U - I, all digits
  const auto divided = [&](const Matrix3d& of) {
    Matrix3d in = Q.transpose() * of * Q;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        in(i, j) /= stretch[i] + stretch[j];
    return Matrix3d(Q * in * Q.transpose());
  };
  const auto stress_of = [&](const Matrix3d& biot) {
    Vector6 v = to_voigt(biot);
    v.tail<3>() *= 2;
    const Vector6 t = stiffness * v;
    Matrix3d T;
    T << t[0], t[5], t[4], t[5], t[1], t[3], t[4], t[3], t[2];
    return T;
  };
  const Matrix3d biot = Q * strain.asDiagonal() * Q.transpose(), T = stress_of(biot), S = 2 * divided(T);
  LawResponse response;
  response.energy = 0.5 * T.cwiseProduct(biot).sum();
  response.stress = to_voigt(S);
  for (int q = 0; q < 6; ++q) {
    Matrix3d dE = Matrix3d::Zero();
    const auto [k, l] = voigt_axes[q];
    dE(k, l) += 0.5, dE(l, k) += 0.5;
    const Matrix3d dU = 2 * divided(dE), dT = stress_of(dU);
    response.tangent.col(q) = to_voigt(divided(2 * dT - dU * S - S * dU));
  }
  return response;
}

} // namespace maille
