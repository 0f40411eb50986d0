#include "maille/materials/law.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace maille {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Axes of the entries in Voigt order.
constexpr std::array<std::array<int, 2>, 6> voigt_axes{{{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}};

/// A symmetric tensor as a stress: shears without factor 2.
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

/// Chain rule for f(z). Any function of E is represented as a LawResponse: value, gradient, Hessian.
LawResponse chain(const LawResponse& z, double value, double first, double second) {
  return {value, first * z.stress, first * z.tangent + second * z.stress * z.stress.transpose()};
}

LawResponse exponential(const LawResponse& z, double factor) {
  const double slope = factor * std::exp(z.energy);
  return chain(z, factor * std::expm1(z.energy), slope, slope); // minus its value at rest
}

LawResponse operator*(double factor, const LawResponse& z) {
  return chain(z, factor * z.energy, factor, 0);
}

LawResponse operator+(const LawResponse& a, const LawResponse& b) {
  return {a.energy + b.energy, a.stress + b.stress, a.tangent + b.tangent};
}

LawResponse operator*(const LawResponse& a, const LawResponse& b) {
  const Matrix6 mixed = a.stress * b.stress.transpose();
  return {a.energy * b.energy, a.energy * b.stress + b.energy * a.stress,
          a.energy * b.tangent + b.energy * a.tangent + mixed + mixed.transpose()};
}

/// Invariants of a strain. Logarithms keep all digits at small strains, where I1~ - 3 would cancel.
class Invariants {
public:
  const Vector6 one = to_voigt(Matrix3d::Identity());
  const double trace, square; ///< tr E, tr E^2
  LawResponse log_J;

  Invariants(const Matrix3d& E, const Vector3d& fibre)
      : trace(E.trace()), square(E.squaredNorm()), E_(E), fibre_(fibre) {
    const Matrix3d inverse = (Matrix3d::Identity() + 2 * E).inverse();
    const double C_minus_1 = 2 * trace + 4 * minors() + 8 * E.determinant();
    log_J = {0.5 * std::log1p(std::max(C_minus_1, -1.0)), to_voigt(inverse), derivative_of_inverse(inverse)};
  }

  LawResponse strain_square() const { return {square, 2 * to_voigt(E_), 2 * symmetric()}; }
  /// E_ff = f.E f
  LawResponse fibre_strain() const {
    return {fibre_.dot(E_ * fibre_), to_voigt(fibre_ * fibre_.transpose()), Matrix6::Zero()};
  }
  /// |E f|^2
  LawResponse fibre_square() const {
    const Vector3d Ef = E_ * fibre_;
    const Matrix3d half = Ef * fibre_.transpose(), ff = fibre_ * fibre_.transpose();
    Matrix6 H;
    for (int p = 0; p < 6; ++p)
      for (int q = 0; q < 6; ++q) {
        const auto [i, j] = voigt_axes[p];
        const auto [k, l] = voigt_axes[q];
        H(p, q) =
            0.5 * ((i == k) * ff(j, l) + (i == l) * ff(j, k) + (j == k) * ff(i, l) + (j == l) * ff(i, k));
      }
    return {Ef.squaredNorm(), to_voigt(half + half.transpose()), H};
  }
  /// ln(I1~ / 3)
  LawResponse log_I1() const { return log({2 * trace / 3, 2.0 / 3 * one, Matrix6::Zero()}, 2.0 / 3); }
  /// ln(I2~ / 3)
  LawResponse log_I2() const {
    return log(4.0 / 3 *
                   LawResponse{trace + minors(), (1 + trace) * one - to_voigt(E_),
                               one * one.transpose() - symmetric()},
               4.0 / 3);
  }
  /// ln I4~
  LawResponse log_I4() const { return log(2 * fibre_strain(), 2.0 / 3); }
  /// ln w, w = (I1~ I4~ - I5~) / (2 sqrt I4~); (I1 I4 - I5) / 2 - 1 = tr E + E_ff + 2 tr E E_ff - 2 |E f|^2
  LawResponse log_cosh_B2() const {
    const LawResponse tr{trace, one, Matrix6::Zero()}, ff = fibre_strain();
    return log(tr + ff + 2 * (tr * ff) + -2 * fibre_square(), 4.0 / 3) + -0.5 * log_I4();
  }

private:
  double minors() const { return 0.5 * (trace * trace - square); }
  static Matrix6 symmetric() { return (Vector6() << 1, 1, 1, 0.5, 0.5, 0.5).finished().asDiagonal(); }
  /// ln(1 + x) - power ln J
  LawResponse log(const LawResponse& x, double power) const {
    const double slope = 1 / (1 + x.energy);
    return chain(x, std::log1p(x.energy), slope, -slope * slope) + -power * log_J;
  }

  const Matrix3d& E_;
  const Vector3d& fibre_;
};

/// k/2 (ln J)^2
LawResponse volume_energy(const Invariants& at, double k) {
  return chain(at.log_J, 0.5 * k * at.log_J.energy * at.log_J.energy, k * at.log_J.energy, k);
}

LawResponse respond(const NeoHookean& law, const Invariants& at) {
  LawResponse response = volume_energy(at, law.lambda) + -law.mu * at.log_J;
  response.energy += law.mu * at.trace;
  response.stress += law.mu * at.one;
  return response;
}

LawResponse respond(const MooneyRivlin& law, const Invariants& at) {
  return exponential(at.log_I1(), 3 * law.c1) + exponential(at.log_I2(), 3 * law.c2) +
         volume_energy(at, law.k);
}

LawResponse respond(const Guccione& law, const Invariants& at) {
  const LawResponse ff = at.fibre_strain();
  const LawResponse Q = (law.bf + law.bt - 2 * law.bfs) * (ff * ff) + law.bt * at.strain_square() +
                        2 * (law.bfs - law.bt) * at.fibre_square();
  return exponential(Q, 0.5 * law.C) + volume_energy(at, law.k);
}

LawResponse respond(const HolzapfelGasserOgden& law, const Invariants& at) {
  const LawResponse I1 = exponential(at.log_I1(), 3);
  const LawResponse A = law.kappa * I1 + (1 - 3 * law.kappa) * exponential(at.log_I4(), 1);
  const double L = at.log_J.energy, swelling = std::expm1(2 * L);
  const LawResponse rest = 0.5 * law.c * I1 + chain(at.log_J, 0.5 * law.k * (0.5 * swelling - L),
                                                    0.5 * law.k * swelling, law.k * (swelling + 1));
  if (A.energy < 0)
    return rest;
  const double a = law.k2 * A.energy * A.energy, slope = law.k1 * std::exp(a);
  return rest + chain(A, 0.5 * law.k1 / law.k2 * std::expm1(a), slope * A.energy, slope * (1 + 2 * a));
}

/// B2^2 as a function of ln cosh B2: derivatives 2 B coth B and 2 coth B (coth B - B / sinh^2 B).
LawResponse shear_across(const LawResponse& log_cosh) {
  const double l = std::max(log_cosh.energy, 0.0), m = std::expm1(l),
               B = std::log1p(m + std::sqrt(m * (m + 2)));
  if (B == 0)
    return chain(log_cosh, 0, 2, 4.0 / 3);
  const double x = 2 * B, xx = x * x, coth = 1 / std::tanh(B), sinh = std::sinh(B);
  // sinh x - x, by its series for small x, where the difference would lose digits
  const double rest = x < 0.3 ? x * xx / 6 * (1 + xx / 20 * (1 + xx / 42 * (1 + xx / 72))) : std::sinh(x) - x;
  return chain(log_cosh, B * B, x * coth, coth * rest / (sinh * sinh));
}

/// Energy of a muscle's fibre over smax at r = stretch / Lofl, and its first and second derivative by r.
std::array<double, 3> fibre_energy(const Muscle& law, double r) {
  const double v = r - 1, a = std::abs(v), sign = v < 0 ? -1 : 1;
  std::array<double, 3> active{sign * (0.016 / 3 + 1.0 / 3), 0, 0};
  if (a <= 0.4)
    active = {v - 4 * v * v * v / 3, 1 - 4 * v * v, -8 * v};
  else if (a < 0.6)
    active = {active[0] + sign * 3 * (a - 0.6) * (a - 0.6) * (a - 0.6), 9 * (a - 0.6) * (a - 0.6),
              sign * 18 * (a - 0.6)};
  for (double& of : active)
    of *= law.activation;
  if (v < 0)
    return active;
  // Exponential up to lam_max, then its tangent line.
  const double curved = std::min(v, law.lam_max / law.Lofl - 1), straight = v - curved,
               force = law.p1 * std::expm1(law.p2 * curved), slope = law.p2 * (force + law.p1);
  return {active[0] + force / law.p2 - law.p1 * curved + (force + 0.5 * slope * straight) * straight,
          active[1] + force + slope * straight, active[2] + slope};
}

LawResponse respond(const Muscle& law, const Invariants& at) {
  const LawResponse ff = at.fibre_strain(), log_I4 = at.log_I4();
  const double I4 = 1 + 2 * ff.energy, s = 0.5 * log_I4.energy, r = std::exp(s) / law.Lofl;
  const LawResponse shear_along = // B1^2
      (at.fibre_square() + -1 * (ff * ff)) *
      chain(ff, 4 / (I4 * I4), -16 / (I4 * I4 * I4), 96 / (I4 * I4 * I4 * I4));
  const auto [energy, force, slope] = fibre_energy(law, r);
  const double by_s = law.smax * force * r;
  return law.g1 * shear_along + law.g2 * shear_across(at.log_cosh_B2()) + volume_energy(at, law.k) +
         chain(log_I4, law.smax * energy + 2.25 * law.g3 * s * s, 0.5 * by_s + 2.25 * law.g3 * s,
               0.25 * (by_s + law.smax * slope * r * r) + 1.125 * law.g3);
}

/// Transversely isotropic constants of a compliance.
ElasticConstants from_compliance(double S11, double S12, double S22, double S23, double G_fibre) {
  return ElasticConstants::transversely_isotropic(1 / S11, 1 / S22, G_fibre, -S12 / S11, -S23 / S22);
}

/// @param axial second derivative of the energy by the fibre strain at constant volume; 3 G if isotropic
ElasticConstants of_split_law(double k, double axial, double G_fibre, double G_cross) {
  const double v = 1 / (9 * k), a = 1 / axial, c = 1 / (4 * G_cross);
  return from_compliance(v + a, v - a / 2, v + a / 4 + c, v + a / 4 - c, G_fibre);
}

ElasticConstants rest_constants(const NeoHookean& law) {
  const double nu = law.lambda / (2 * (law.lambda + law.mu));
  return ElasticConstants::isotropic(2 * law.mu * (1 + nu), nu);
}

ElasticConstants rest_constants(const MooneyRivlin& law) {
  const double G = 2 * (law.c1 + law.c2);
  return rest_constants(NeoHookean{G, law.k - 2 * G / 3});
}

/// Stiffness of the normal strains: k + diag(C bf, C bt, C bt), inverted by Sherman and Morrison's formula.
ElasticConstants rest_constants(const Guccione& law) {
  const double a = 1 / (law.C * law.bf), b = 1 / (law.C * law.bt), s = 1 / (1 / law.k + a + 2 * b);
  return from_compliance(a - s * a * a, -s * a * b, b - s * b * b, -s * b * b, 0.5 * law.C * law.bfs);
}

ElasticConstants rest_constants(const HolzapfelGasserOgden& law) {
  const double parallel = 1 - 3 * law.kappa;
  return of_split_law(law.k, 3 * law.c + 4 * law.k1 * parallel * parallel, law.c, law.c);
}

ElasticConstants rest_constants(const Muscle& law) {
  Muscle passive = law;
  passive.activation = 0;
  const double slope = fibre_energy(passive, 1 / law.Lofl)[2];
  return of_split_law(law.k, 4.5 * law.g3 + law.smax * slope / (law.Lofl * law.Lofl), 2 * law.g1, 2 * law.g2);
}

using Parameters = std::vector<std::pair<std::string_view, double*>>;

Parameters parameters(NeoHookean& of) {
  return {{"mu", &of.mu}, {"lambda", &of.lambda}};
}

Parameters parameters(MooneyRivlin& of) {
  return {{"c1", &of.c1}, {"c2", &of.c2}, {"k", &of.k}};
}

Parameters parameters(Guccione& of) {
  return {{"C", &of.C}, {"bf", &of.bf}, {"bt", &of.bt}, {"bfs", &of.bfs}, {"k", &of.k}};
}

Parameters parameters(HolzapfelGasserOgden& of) {
  return {{"c", &of.c}, {"k1", &of.k1}, {"k2", &of.k2}, {"kappa", &of.kappa}, {"k", &of.k}};
}

Parameters parameters(Muscle& of) {
  return {{"g1", &of.g1},
          {"g2", &of.g2},
          {"g3", &of.g3},
          {"p1", &of.p1},
          {"p2", &of.p2},
          {"Lofl", &of.Lofl},
          {"lam_max", &of.lam_max},
          {"smax", &of.smax},
          {"activation", &of.activation},
          {"k", &of.k}};
}

} // namespace

LawResponse respond(const Law& law, const Matrix3d& E, const Vector3d& fibre) {
  const Invariants at(E, fibre);
  LawResponse response = std::visit([&](const auto& of) { return respond(of, at); }, law);
  if (!std::isfinite(response.energy))
    response.energy = std::numeric_limits<double>::infinity(); // also for inf - inf
  return response;
}

ElasticConstants rest_constants(const Law& law) {
  return std::visit([](const auto& of) { return rest_constants(of); }, law);
}

bool is_isotropic(const Law& law) {
  const auto* const fibred = std::get_if<HolzapfelGasserOgden>(&law);
  return fibred ? fibred->k1 == 0 || 3 * fibred->kappa >= 1 : law.index() < 2;
}

std::string_view name_of(const Law& law) {
  constexpr std::array<std::string_view, 5> names{"neo_hookean", "mooney_rivlin", "guccione",
                                                  "holzapfel_gasser_ogden", "muscle"};
  return names[law.index()];
}

std::vector<std::pair<std::string_view, double*>> parameters(Law& law) {
  return std::visit([](auto& of) { return parameters(of); }, law);
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
