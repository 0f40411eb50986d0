/// Laws of large strain against their published energies, written anew in long double and differentiated, and
/// against closed forms of nominal stress; and the faults of their reader.

#include "maille/materials/law.hpp"
#include "maille/materials/library.hpp"
#include "maille/materials/material.hpp"
#include "materials/constants_and_faults.hpp"
#include "support/kit.hpp"

#include <Eigen/Dense>

namespace maille {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Number = long double;
using Matrix3 = Eigen::Matrix<Number, 3, 3>;
using Vector3 = Eigen::Matrix<Number, 3, 1>;

constexpr std::uint64_t seed = 4711;
constexpr double kPa = 1e3;
constexpr std::array<std::array<int, 2>, 6> axes_of{{{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}};

/// Every law, muscle passive, active, and taut from the start.
std::vector<Law> laws() {
  const Muscle muscle{500, 600, 0.05, 6.6, 1.4, 1.5, 3e5, 0, 2e4, 700};
  Muscle active = muscle, taut = muscle;
  active.activation = 0.7, active.Lofl = 1.1, active.lam_max = 1.2;
  taut.Lofl = 1, taut.smax = 2e4;
  return {NeoHookean{1e3, 5e3},
          MooneyRivlin{400, 150, 2e4},
          Guccione{2e3, 8, 2, 4, 5e4},
          HolzapfelGasserOgden{1e3, 4e3, 1.5, 0.1, 3e4},
          HolzapfelGasserOgden{1e3, 4e3, 1.5, 1.0 / 3, 3e4},
          muscle,
          active,
          taut};
}

bool is_active(const Law& law) {
  const auto* muscle = std::get_if<Muscle>(&law);
  return muscle && muscle->activation > 0;
}

// Truth: the energies as their authors print them, of F = sqrt(C), in a frame whose first axis is the fibre;
// the muscle's fibre integrated from Blemker's piecewise forces.

/// Gauss and Legendre's rule of five points on four parts.
template<class Function>
Number integral(const Function& f, Number from, Number to) {
  constexpr std::array<std::array<Number, 2>, 3> rule{{{0, 0.568888888888888888889L / 2},
                                                       {0.538469310105683091036L, 0.478628670499366468041L},
                                                       {0.906179845938663992798L, 0.236926885056189087514L}}};
  const Number half = (to - from) / 8;
  Number sum = 0;
  for (int part = 0; part < 4; ++part)
    for (const auto& [at, weight] : rule)
      for (const int sign : {-1, 1})
        sum += half * weight * f(from + half * (2 * part + 1 + sign * at));
  return sum;
}

Number force_of_fibre(const Muscle& m, Number stretch) {
  const Number r = stretch / m.Lofl, last = Number(m.lam_max) / m.Lofl, d = std::abs(r - 1);
  const auto toe = [&](Number x) { return m.p1 * (std::exp(m.p2 * (x - 1)) - 1); };
  const Number passive =
      r < 1 ? 0 : (r < last ? toe(r) : m.p1 * m.p2 * std::exp(m.p2 * (last - 1)) * (r - last) + toe(last));
  const Number active = d <= 0.4L ? 1 - 4 * d * d : (d < 0.6L ? 9 * (d - 0.6L) * (d - 0.6L) : 0);
  return m.smax * (passive + m.activation * active) / m.Lofl; // by the stretch
}

Number energy_of_fibre(const Muscle& m, Number stretch) {
  std::vector<Number> kinks{m.Lofl, m.lam_max};
  for (const Number at : {0.4L, 0.6L, 1.4L, 1.6L})
    kinks.push_back(at * m.Lofl);
  std::ranges::sort(kinks);
  Number sum = 0, from = 0.2L; // below every stretch that is drawn
  for (const Number kink : kinks)
    if (kink > from && kink < stretch)
      sum += integral([&](Number l) { return force_of_fibre(m, l); }, from, kink), from = kink;
  return sum + integral([&](Number l) { return force_of_fibre(m, l); }, from, stretch);
}

struct Published {
  Matrix3 C;        ///< axis 1 is the fibre
  Number J, I1, I2; ///< of C; the last two isochoric

  Published(const Matrix3& E, const Vector3& fibre) {
    const Vector3 other = std::abs(fibre[0]) < 0.7L ? Vector3::UnitX() : Vector3::UnitY();
    Matrix3 axes;
    axes.col(0) = fibre;
    axes.col(1) = fibre.cross(other).normalized();
    axes.col(2) = fibre.cross(axes.col(1));
    C = axes.transpose() * (Matrix3::Identity() + 2 * E) * axes;
    J = std::sqrt(C.determinant());
    const Matrix3 isochoric = C / std::pow(J, 2.0L / 3);
    I1 = isochoric.trace();
    I2 = (I1 * I1 - (isochoric * isochoric).trace()) / 2;
  }
  Number volume(double k) const { return k / 2.0L * std::log(J) * std::log(J); }

  Number operator()(const NeoHookean& l) const {
    const Number L = std::log(J);
    return l.mu / 2 * (C.trace() - 3) - l.mu * L + l.lambda / 2 * L * L;
  }
  Number operator()(const MooneyRivlin& l) const { return l.c1 * (I1 - 3) + l.c2 * (I2 - 3) + volume(l.k); }
  Number operator()(const Guccione& l) const {
    const Matrix3 E = (C - Matrix3::Identity()) / 2;
    const Number Q = l.bf * E(0, 0) * E(0, 0) +
                     l.bt * (E(1, 1) * E(1, 1) + E(2, 2) * E(2, 2) + 2 * E(1, 2) * E(1, 2)) +
                     2 * l.bfs * (E(0, 1) * E(0, 1) + E(0, 2) * E(0, 2));
    return l.C / 2 * (std::exp(Q) - 1) + volume(l.k);
  }
  Number operator()(const HolzapfelGasserOgden& l) const {
    const Number I4 = C(0, 0) / std::pow(J, 2.0L / 3);
    const Number A = std::max(l.kappa * (I1 - 3) + (1 - 3 * l.kappa) * (I4 - 1), Number(0));
    return l.c / 2 * (I1 - 3) + l.k1 / (2 * l.k2) * (std::exp(l.k2 * A * A) - 1) +
           l.k / 2 * ((J * J - 1) / 2 - std::log(J));
  }
  Number operator()(const Muscle& l) const {
    const Matrix3 D = C / std::pow(J, 2.0L / 3);
    const Number I4 = D(0, 0), I5 = (D * D)(0, 0), stretch = std::sqrt(I4);
    const Number B1 = std::sqrt(std::max(I5 / (I4 * I4) - 1, Number(0)));
    const Number B2 = std::acosh(std::max((I1 * I4 - I5) / (2 * stretch), Number(1)));
    return l.g1 * B1 * B1 + l.g2 * B2 * B2 + 2.25L * l.g3 * std::log(stretch) * std::log(stretch) +
           energy_of_fibre(l, stretch) + volume(l.k);
  }
};

Number published_energy(const Law& law, const Matrix3& E, const Vector3d& fibre) {
  return std::visit(Published(E, fibre.cast<Number>().normalized()), law);
}

/// Derivative by the engineering strain p; central, with Richardson's extrapolation.
template<class Function>
auto derivative(const Function& f, const Matrix3& E, int p, Number h) {
  const auto central = [&](Number step) {
    const auto [i, j] = axes_of[p];
    Matrix3 plus = E, minus = E;
    plus(i, j) += step / 2, plus(j, i) += step / 2;
    minus(i, j) -= step / 2, minus(j, i) -= step / 2;
    return Number((f(plus) - f(minus)) / (2 * step));
  };
  return (4 * central(h) - central(2 * h)) / 3;
}

Matrix3d random_strain(test::RandomMaterials& random, double size) {
  Matrix3d F;
  do
    F = Matrix3d::Identity() + size * Matrix3d::NullaryExpr([&] { return random.between(-1, 1); });
  while (F.determinant() < 0.4);
  return 0.5 * (F.transpose() * F - Matrix3d::Identity());
}

TEST(LawOracle, StressAndTangentOfPublishedEnergies) {
  SCOPED_TRACE(seed);
  test::RandomMaterials random(seed);
  const Number h = 1e-4L;
  for (int i = 0; i < 200; ++i)
    for (const Law& law : laws()) {
      const Matrix3d E = random_strain(random, i % 2 == 0 ? 0.35 : 0.05);
      const Vector3d fibre = random.direction();
      const LawResponse found = respond(law, E, fibre);
      const auto energy = [&](const Matrix3& at) { return published_energy(law, at, fibre); };
      Vector6 stress;
      Matrix6 tangent;
      for (int p = 0; p < 6; ++p) {
        stress[p] = static_cast<double>(derivative(energy, E.cast<Number>(), p, h));
        for (int q = 0; q <= p; ++q)
          tangent(p, q) = tangent(q, p) = static_cast<double>(derivative(
              [&](const Matrix3& at) { return derivative(energy, at, q, h); }, E.cast<Number>(), p, h));
      }
      SCOPED_TRACE(fmt::format("{} of draw {}", name_of(law), i));
      const Matrix3 rest = Matrix3::Zero();
      const double expected = static_cast<double>(energy(E.cast<Number>()) - energy(rest)) +
                              respond(law, Matrix3d::Zero(), fibre).energy;
      EXPECT_NEAR(found.energy, expected, 1e-9 * (1e3 + std::abs(expected)));
      EXPECT_LT((found.stress - stress).cwiseAbs().maxCoeff(), 1e-6 * stress.cwiseAbs().maxCoeff());
      EXPECT_LT((found.tangent - tangent).cwiseAbs().maxCoeff(), 1e-6 * tangent.cwiseAbs().maxCoeff());
      if (HasFailure())
        return;
    }
}

TEST(LawAnalytic, Rest) {
  for (const Law& law : laws()) {
    SCOPED_TRACE(name_of(law));
    const Vector3d fibre = Vector3d(1, 2, -2) / 3;
    const LawResponse found = respond(law, Matrix3d::Zero(), fibre);
    if (is_active(law))
      continue;
    const Matrix6 linear = turned(stiffness(rest_constants(law)), axes_from_fibre(fibre));
    EXPECT_EQ(found.energy, 0);
    EXPECT_LT(found.stress.cwiseAbs().maxCoeff(), 1e-11 * linear.maxCoeff());
    EXPECT_LT((found.tangent - linear).cwiseAbs().maxCoeff(), 1e-12 * linear.maxCoeff());
    EXPECT_EQ(rest_constants(law).is_isotropic(), is_isotropic(law));
    // Truth: 1/2 strain . stiffness . strain, to the next power of the strain. In I1~ - 3 as it is written,
    // 1e-6 would be lost in rounding.
    test::RandomMaterials random(seed);
    const Matrix3d small = 1e-6 * random_strain(random, 0.3);
    Vector6 strain;
    for (int p = 0; p < 6; ++p)
      strain[p] = (p < 3 ? 1 : 2) * small(axes_of[p][0], axes_of[p][1]);
    const double energy = 0.5 * strain.dot(respond(law, small, fibre).tangent * strain);
    EXPECT_NEAR(respond(law, small, fibre).energy, energy, 1e-4 * energy);
  }
}

TEST(LawAnalytic, RestModuli) {
  // Truth: second derivatives of the energies by hand: shear along and across the fibre, bulk modulus.
  const auto expect = [](const Law& law, double along, double across, double bulk) {
    const ElasticConstants c = rest_constants(law);
    EXPECT_NEAR(c.G12, along, 1e-12 * along);
    EXPECT_NEAR(c.G23, across, 1e-12 * across);
    const Matrix6 C = stiffness(c);
    EXPECT_NEAR((C.topLeftCorner<3, 3>().sum() / 9), bulk, 1e-9 * bulk);
  };
  expect(NeoHookean{1e3, 5e3}, 1e3, 1e3, 5e3 + 2e3 / 3);
  expect(MooneyRivlin{400, 150, 2e4}, 1100, 1100, 2e4);
  expect(Guccione{2e3, 8, 2, 4, 5e4}, 4e3, 2e3, 5e4 + 2e3 * (8 + 2 + 2) / 9);
  expect(HolzapfelGasserOgden{1e3, 4e3, 1.5, 0.1, 3e4}, 1e3, 1e3, 3e4);
  expect(Muscle{500, 600, 0.05, 6.6, 1.4, 1.5, 3e5, 0, 2e4, 700}, 1e3, 1200, 2e4);
  // g3 = 4/3 g1 = 4/3 g2: isotropic at rest, though the law is not.
  const Law even = Muscle{300, 300, 0.05, 6.6, 1.4, 1.5, 3e5, 0, 2e4, 400};
  EXPECT_TRUE(rest_constants(even).is_isotropic());
  EXPECT_FALSE(is_isotropic(even));
  Material material;
  material.elasticity = rest_constants(even);
  EXPECT_TRUE(is_isotropic(material));
  material.law = even;
  EXPECT_FALSE(is_isotropic(material));
}

TEST(LawAnalytic, Objectivity) {
  SCOPED_TRACE(seed);
  test::RandomMaterials random(seed);
  for (const Law& law : laws())
    for (int i = 0; i < 20; ++i) {
      const Matrix3d E = random_strain(random, 0.3), R = random.rotation();
      const Vector3d fibre = random.direction();
      const LawResponse a = respond(law, E, fibre), b = respond(law, R * E * R.transpose(), R * fibre);
      Matrix3d S;
      S << a.stress[0], a.stress[5], a.stress[4], a.stress[5], a.stress[1], a.stress[3], a.stress[4],
          a.stress[3], a.stress[2];
      const Matrix3d S_turned = R * S * R.transpose();
      EXPECT_NEAR(a.energy, b.energy, 1e-11 * (1e3 + std::abs(a.energy)));
      for (int p = 0; p < 6; ++p)
        EXPECT_NEAR(b.stress[p], S_turned(axes_of[p][0], axes_of[p][1]),
                    1e-11 * (1e3 + S.cwiseAbs().maxCoeff()));
      EXPECT_LT((b.tangent - turned(a.tangent, R)).cwiseAbs().maxCoeff(),
                1e-10 * a.tangent.cwiseAbs().maxCoeff());
    }
}

/// Nominal stress along `axis` at the stretch there, with the axes `free` at the stretch of no stress.
double nominal(const Law& law, int axis, double stretch, std::vector<int> free,
               const Vector3d& fibre = Vector3d::UnitX()) {
  Matrix3d E = Matrix3d::Zero();
  E(axis, axis) = 0.5 * (stretch * stretch - 1);
  const double across = std::pow(stretch, -2.0 / static_cast<double>(free.size()));
  for (const int a : free)
    E(a, a) = 0.5 * (across - 1); // incompressible
  const auto n = static_cast<Eigen::Index>(free.size());
  for (int i = 0; i < 100; ++i) { // Newton's iterations
    const LawResponse at = respond(law, E, fibre);
    const Eigen::VectorXd step =
        at.tangent(free, free).partialPivLu().solve(Eigen::VectorXd(at.stress(free)));
    for (Eigen::Index j = 0; j < n; ++j)
      E(free[j], free[j]) -= step[j];
  }
  return stretch * respond(law, E, fibre).stress[axis];
}

TEST(LawAnalytic, NeoHookeanNominalStress) {
  const NeoHookean law{1, 1e6};
  // Truth: mu (l - l^-2) in uniaxial tension, mu (l - l^-3) in plane strain, both incompressible.
  for (const auto& [stretch, stress] :
       {std::pair{0.6, -2.177778}, {0.8, -0.7625}, {1.2, 0.505556}, {1.4, 0.889796}, {1.6, 1.209375}})
    EXPECT_NEAR(nominal(law, 0, stretch, {1, 2}), stress, 1e-5) << stretch;
  for (const auto& [stretch, stress] :
       {std::pair{0.6, -4.02963}, {0.8, -1.153125}, {1.2, 0.621296}, {1.4, 1.035569}})
    EXPECT_NEAR(nominal(law, 0, stretch, {1}), stress, 2e-5) << stretch; // compressed by stress / lambda
}

TEST(LawAnalytic, MooneyRivlinNominalStress) {
  const MooneyRivlin law{0.3, 0.2, 1e6};
  for (const double l : {0.6, 0.8, 1.2, 1.6, 2.5}) {
    // Truth: incompressible, 2 (l - l^-2) (c1 + c2 / l) uniaxial, 2 (l - l^-3) (c1 + c2) in plane strain.
    EXPECT_NEAR(nominal(law, 0, l, {1, 2}), 2 * (l - 1 / (l * l)) * (0.3 + 0.2 / l), 1e-5) << l;
    EXPECT_NEAR(nominal(law, 0, l, {1}), 2 * (l - 1 / (l * l * l)) * 0.5, 1e-5) << l;
  }
}

TEST(LawAnalytic, GuccioneNominalStress) {
  const Guccione law{2, 8, 2, 4, 1e6};
  // Truth: kPa, incompressible: P = dW/dl with the other stretches l^-1/2 along the fibre; across, the
  // fibre's stretch is that of least energy.
  for (const auto& [stretch, stress] :
       {std::pair{0.9, -1.78724}, {1.05, 0.96970}, {1.1, 2.20063}, {1.15, 3.96277}, {1.2, 6.74710}})
    EXPECT_NEAR(nominal(law, 0, stretch, {1, 2}), stress, 4e-5) << stretch;
  for (const auto& [stretch, stress] : {std::pair{1.1, 0.7131}, {1.2, 1.5873}, {1.3, 2.9459}})
    EXPECT_NEAR(nominal(law, 1, stretch, {0, 2}), stress, 1e-4) << stretch;
}

TEST(LawAnalytic, HolzapfelNominalStress) {
  const HolzapfelGasserOgden law{1, 2, 1.5, 0, 1e8};
  for (const double l : {0.7, 0.9, 1.1, 1.3}) {
    // Truth: incompressible with parallel fibres, c (l - l^-2) + 2 k1 l A exp(k2 A^2), A = l^2 - 1 if > 0.
    const double A = std::max(l * l - 1, 0.0);
    EXPECT_NEAR(nominal(law, 0, l, {1, 2}), l - 1 / (l * l) + 4 * l * A * std::exp(1.5 * A * A), 2e-5) << l;
  }
}

TEST(LawAnalytic, MuscleNominalStress) {
  // Truth: incompressible, B1 = B2 = 0: P = smax (passive + activation active) / Lofl + 9/2 g3 ln l / l.
  for (const double activation : {0.0, 0.6})
    for (const double l : {0.5, 0.6, 0.7, 0.9, 1.15, 1.3, 1.5, 1.75}) {
      const Muscle law{0.5, 0.6, 0.05, 6.6, 1.1, 1.4, 300, activation, 1e9, 0.7};
      EXPECT_NEAR(nominal(law, 0, l, {1, 2}),
                  static_cast<double>(force_of_fibre(law, l)) + 4.5 * 0.7 * std::log(l) / l, 1e-3)
          << l;
    }
}

TEST(LawAnalytic, MuscleShear) {
  const Muscle law{500, 600, 0.05, 6.6, 1.4, 1.5, 3e5, 0, 2e4, 700};
  for (const double size : {1e-9, 1e-3, 0.1, 0.14, 0.16, 0.7}) {
    // Truth: a shear gamma along the fibre has B1 = gamma and B2 = 0; a pure shear across it,
    // diag(1, l, 1/l), has B1 = 0 and B2 = 2 ln l.
    Matrix3d along = Matrix3d::Zero(), across = Matrix3d::Zero();
    along(0, 1) = along(1, 0) = 0.5 * size, along(1, 1) = 0.5 * size * size;
    across.diagonal() << 0, 0.5 * std::expm1(2 * size), 0.5 * std::expm1(-2 * size);
    EXPECT_NEAR(respond(law, along, Vector3d::UnitX()).energy, 500 * size * size, 1e-12 + 1e-9 * size);
    EXPECT_NEAR(respond(law, across, Vector3d::UnitX()).energy, 2400 * size * size, 1e-12 + 1e-9 * size);
    // S22 = dW/dE22 = dW/dl / l at l3 = 1/l: g2 4 ln l / l^2, and -g2 4 ln l l^2 across; no pressure.
    const Vector6 S = respond(law, across, Vector3d::UnitX()).stress;
    EXPECT_NEAR(S[1], 2400 * size * std::exp(-2 * size), 1e-9 + 1e-9 * size);
    EXPECT_NEAR(S[2], -2400 * size * std::exp(2 * size), 1e-9 + 1e-9 * size);
  }
}

TEST(LawAnalytic, MuscleAtRestPullsWhenActive) {
  Muscle law{500, 600, 0.05, 6.6, 1, 1.5, 3e5, 0.5, 2e4, 700};
  // Truth: at Lofl the active force is smax activation, isochoric: (2/3, -1/3, -1/3) of it.
  const Vector6 S = respond(law, Matrix3d::Zero(), Vector3d::UnitX()).stress;
  EXPECT_NEAR(S[0], 1e5, 1e-9);
  EXPECT_NEAR(S[1], -0.5e5, 1e-9);
  law.activation = 0;
  EXPECT_EQ(rest_constants(law).youngs_modulus,
            rest_constants(Muscle{500, 600, 0.05, 6.6, 1, 1.5, 3e5, 1, 2e4, 700}).youngs_modulus);
}

TEST(LawContract, EnergyIsNeverNaN) {
  const double most = std::numeric_limits<double>::max();
  std::vector<Law> all = laws();
  all.push_back(NeoHookean{1e3, -500});
  for (const Law& law : all)
    for (const double large : {10.0, 1e3, 1e60, 1e200, most}) {
      Matrix3d E = Matrix3d::Zero();
      E(0, 0) = large;
      EXPECT_FALSE(std::isnan(respond(law, E, Vector3d::UnitX()).energy)) << name_of(law);
      EXPECT_FALSE(std::isnan(respond(law, large * Matrix3d::Ones(), Vector3d::UnitX()).energy));
      EXPECT_EQ(respond(law, -0.5 * Matrix3d::Identity(), Vector3d::UnitX()).energy,
                std::numeric_limits<double>::infinity())
          << name_of(law);
    }
  Matrix3d E = Matrix3d::Zero();
  E(0, 0) = 1e3;
  EXPECT_EQ(respond(Guccione{2e3, 8, 2, 4, 5e4}, E, Vector3d::UnitX()).energy,
            std::numeric_limits<double>::infinity());
}

TEST(LawContract, BrokenRules) {
  const auto broken = [](const Law& law) {
    std::string keys;
    for (const BrokenRule& rule : broken_rules(law))
      keys += rule.key + " ";
    return keys;
  };
  for (const Law& law : laws())
    EXPECT_EQ(broken(law), "") << name_of(law);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(broken(NeoHookean{0, nan}), "mu lambda ");
  EXPECT_EQ(broken(NeoHookean{3, -2}), "lambda ");
  EXPECT_EQ(broken(MooneyRivlin{0, -1, 0}), "c1 c2 k ");
  EXPECT_EQ(broken(Guccione{}), "C bf bt bfs k ");
  EXPECT_EQ(broken(HolzapfelGasserOgden{0, -1, 0, 0.34, 0}), "c k1 k2 kappa k ");
  EXPECT_EQ(broken(HolzapfelGasserOgden{1, 0, 1, 1.0 / 3, 1}), "");
  EXPECT_EQ(broken(Muscle{0, 0, -1, 0, 0.9, 0.9, -1, 1.1, 0, 0}),
            "g1 g2 g3 p1 p2 Lofl lam_max smax activation k ");
  EXPECT_EQ(broken(Muscle{1, 1, 0, 1, 1.4, 1.3, 0, 1, 1, 1}), "lam_max ");
  // A bulk modulus far from the rest of the law. Analytic: with shear modulus 4, 1 - 2 nu = 4 / k for large k
  // and 1 + nu = 3 k / 8 for small.
  for (const double k : {4e-4, 4.0, 4e8})
    EXPECT_EQ(broken(MooneyRivlin{1, 1, k}), "") << k;
  for (const double k : {1e-300, 4e-8, 4e10, 1e300})
    EXPECT_EQ(broken(MooneyRivlin{1, 1, k}), "k ") << k;
  EXPECT_EQ(broken(Guccione{2e3, 8, 2, 4, 1e300}), "k ");
  EXPECT_EQ(broken(NeoHookean{1, 1e300}), "lambda ");
  Material material;
  material.law = Guccione{2, 8, 2, 4, -1};
  material.elasticity = ElasticConstants::isotropic(1, 0.3);
  ASSERT_EQ(broken_rules(material).size(), 1U);
  EXPECT_EQ(broken_rules(material)[0].key, "law.k");
}

Material read(std::string_view text) {
  Material material;
  EXPECT_EQ(test::faults_of(
                text, [&](TableReader& table) { EXPECT_TRUE(read_mechanics(table, material)); }, "material"),
            std::vector<std::string>{});
  return material;
}

TEST(LawContract, ReadFromAScene) {
  const Material neo = read("law = 'neo_hookean'\nE = '10 kPa'\nnu = 0.25");
  ASSERT_TRUE(neo.law);
  EXPECT_EQ(*neo.law, Law(NeoHookean{4 * kPa, 4 * kPa}));
  EXPECT_NEAR(neo.elasticity.youngs_modulus[2], 10 * kPa, 1e-9);
  EXPECT_TRUE(neo.elasticity.is_isotropic());
  const std::string guccione =
      "law = 'guccione'\nparameters = { C = '2 kPa', bf = 8, bt = 2, bfs = 4, k = '0.4 MPa' }";
  EXPECT_EQ(*read(guccione).law, Law(Guccione{2 * kPa, 8, 2, 4, 400 * kPa}));
  EXPECT_EQ(read(guccione).elasticity.G12, 4 * kPa);
  EXPECT_EQ(*read("law = 'mooney_rivlin'\nparameters = { c1 = 1, c2 = 2, k = 30 }").law,
            Law(MooneyRivlin{1, 2, 30}));
  EXPECT_EQ(
      *read("law = 'holzapfel_gasser_ogden'\nparameters = { c = 1, k1 = 2, k2 = 3, kappa = 0.1, k = 30 }")
           .law,
      Law(HolzapfelGasserOgden{1, 2, 3, 0.1, 30}));
  EXPECT_EQ(*read("law = 'muscle'\nparameters = { g1 = 1, g2 = 2, g3 = 3, p1 = 0.05, p2 = 6.6, Lofl = 1.2, "
                  "lam_max = 1.4, "
                  "smax = '0.3 MPa', activation = 0.5, k = 1000 }")
                 .law,
            Law(Muscle{1, 2, 0.05, 6.6, 1.2, 1.4, 3e5, 0.5, 1000, 3}));
}

TEST(LawContract, ReaderTellsEachCauseOnce) {
  struct Case {
    const char* text;
    std::vector<std::string> faults; ///< what each line has
  };
  for (const auto& [text, expected] : std::vector<Case>{
           {"law = 'neo_hookian'\nE = 1\nnu = 0.3",
            {"1: law: expected one of: \"neo_hookean\", \"mooney_rivlin\""}},
           {"law = 'neo_hookean'\nnu = 0.3",
            {"E: expected Young's modulus of the law, a pressure, found nothing"}},
           {"law = 'neo_hookean'\nE = -1\nnu = 0.3", {"2: E: expected E > 0, found -1"}},
           {"law = 'neo_hookean'\nE = [1, 1, 1]\nnu = 0.5",
            {"2: E: expected a pressure", "3: nu: expected -1 < nu < 0.5"}},
           {"law = 'neo_hookean'\nE = 1\nnu = 0.3\nG = 2",
            {"4: G: expected no elastic constants beside a law"}},
           {"law = 'neo_hookean'\nE = 1\nnu = 0.3\nparameters = { c1 = 1 }",
            {"4: parameters: expected one of:"}},
           {"law = 'guccione'",
            {"parameters: expected the parameters of guccione: { C, bf, bt, bfs, k }, found nothing"}},
           {"law = 'guccione'\nparameters = 2", {"2: parameters: expected a table, found 2"}},
           {"law = 'mooney_rivlin'\nparameters = { c1 = 1 }\nE_fibre = 3\nE_cross = 2",
            {"2: parameters.c2: expected a pressure", "2: parameters.k: expected a pressure",
             "3: E_fibre: expected no elastic constants beside a law, which has its own at rest, found "
             "E_fibre, E_cross"}},
           {"law = 'mooney_rivlin'\nparameters = { c1 = '1 mm', c2 = -1, k = 0, bf = 8 }",
            {"parameters.c1: expected a pressure", "parameters.c2: expected a pressure",
             "parameters.k: expected a pressure",
             "parameters.bf: expected one of: c1, c2, k, found an unknown key"}},
           {"law = 'muscle'\nparameters = { g1 = 1, g2 = 2, g3 = 3, p1 = 0.05, p2 = 6.6, Lofl = 1.4, lam_max "
            "= 1.2, smax = 1, "
            "activation = 0.5, k = 1000 }",
            {"2: parameters.lam_max: expected lam_max >= Lofl, found 1.2"}},
           {"parameters = { c1 = 1 }\nyoungs_modulus = 1\npoisson_ratio = 0.3",
            {"1: parameters: expected one of:"}}}) {
    Material material;
    std::vector<std::string> found = test::faults_of(
        text, [&](TableReader& table) { read_mechanics(table, material); }, "material");
    SCOPED_TRACE(fmt::format("{}\n{}", text, fmt::join(found, "\n")));
    ASSERT_EQ(found.size(), expected.size());
    for (const std::string& part : expected)
      EXPECT_TRUE(std::ranges::any_of(found, [&](const std::string& line) { return test::has(line, part); }))
          << part;
  }
}

} // namespace
} // namespace maille
