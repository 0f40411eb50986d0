#include "maille/materials/elasticity.hpp"
#include "materials/constants_and_faults.hpp"
#include "support/kit.hpp"

#include <Eigen/Dense>
#include <Eigen/LU>
#include <Eigen/SVD>

namespace maille {
namespace {

constexpr std::uint64_t seed = 20240607;
constexpr int draws = 200;

using Tensor4 = std::array<std::array<std::array<std::array<double, 3>, 3>, 3>, 3>;
constexpr std::array<std::array<std::size_t, 2>, 6> voigt{{{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}};

double largest(const Eigen::MatrixXd& matrix) {
  return matrix.cwiseAbs().maxCoeff();
}

/// Turns a stiffness by its definition, C'_ijkl = R_ip R_jq R_kr R_ls C_pqrs, with no Voigt factor anywhere.
Matrix6 turned_by_tensor(const Matrix6& C, const Eigen::Matrix3d& R) {
  Tensor4 tensor{};
  for (std::size_t I = 0; I < 6; ++I) {
    for (std::size_t J = 0; J < 6; ++J) {
      const auto [i, j] = voigt[I];
      const auto [k, l] = voigt[J];
      const double value = C(static_cast<Eigen::Index>(I), static_cast<Eigen::Index>(J));
      tensor[i][j][k][l] = tensor[j][i][k][l] = tensor[i][j][l][k] = tensor[j][i][l][k] = value;
    }
  }
  const auto r = [&R](std::size_t a, std::size_t b) {
    return R(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
  };
  Matrix6 result = Matrix6::Zero();
  for (std::size_t I = 0; I < 6; ++I) {
    for (std::size_t J = 0; J < 6; ++J) {
      double sum = 0;
      for (std::size_t n = 0; n < 81; ++n) {
        const std::size_t p = n / 27, q = n / 9 % 3, s = n / 3 % 3, t = n % 3;
        sum += r(voigt[I][0], p) * r(voigt[I][1], q) * r(voigt[J][0], s) * r(voigt[J][1], t) *
               tensor[p][q][s][t];
      }
      result(static_cast<Eigen::Index>(I), static_cast<Eigen::Index>(J)) = sum;
    }
  }
  return result;
}

/// Stress of a transversely isotropic solid with fibre `a` in Spencer's form (structural tensor A = a a^T),
/// its five constants taken from the unturned stiffness.
Eigen::Matrix3d spencer_stress(const Matrix6& C, const Eigen::Vector3d& a, const Eigen::Matrix3d& strain) {
  const double lambda = C(1, 2);
  const double mu_cross = (C(1, 1) - C(1, 2)) / 2;
  const double mu_fibre = C(4, 4);
  const double alpha = C(0, 1) - C(1, 2);
  const double beta = C(0, 0) - lambda - 2 * alpha - 4 * mu_fibre + 2 * mu_cross;
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d A = a * a.transpose();
  const double along = a.dot(strain * a);
  return lambda * strain.trace() * I + 2 * mu_cross * strain + alpha * (along * I + strain.trace() * A) +
         2 * (mu_fibre - mu_cross) * (A * strain + strain * A) + beta * along * A;
}

/// The vastus lateralis set of Knight et al. 2022 with nearly incompressible Poisson ratios [Pa].
ElasticConstants vastus_lateralis() {
  return ElasticConstants::transversely_isotropic(41.8e3, 7.38e3, 5.77e3, 0.4396, 0.9012);
}

TEST(ElasticityAnalytic, StiffnessTimesComplianceIsIdentity) {
  SCOPED_TRACE(seed);
  test::RandomMaterials random(seed);
  for (int i = 0; i < draws; ++i) {
    const ElasticConstants constants = random.valid_constants();
    const Matrix6 S = compliance(constants);
    const Matrix6 C = stiffness(constants);
    const double condition = largest(S) * largest(C);
    EXPECT_LT(largest(S * C - Matrix6::Identity()), 1e-13 * condition);
    EXPECT_EQ(largest(C - C.transpose()), 0);
  }
}

TEST(ElasticityAnalytic, IsotropicStiffnessIsLame) {
  const double E = 12e3, nu = 0.3;
  // Truth: Lame's constants, lambda = E nu / ((1 + nu)(1 - 2 nu)), mu = E / (2 (1 + nu)).
  const double lambda = E * nu / ((1 + nu) * (1 - 2 * nu)), mu = E / (2 * (1 + nu));
  Matrix6 expected = Matrix6::Zero();
  expected.topLeftCorner<3, 3>().setConstant(lambda);
  expected.diagonal() << lambda + 2 * mu, lambda + 2 * mu, lambda + 2 * mu, mu, mu, mu;
  EXPECT_LT(largest(stiffness(ElasticConstants::isotropic(E, nu)) - expected), 1e-12 * E);
}

TEST(ElasticityAnalytic, TransverseIsotropyHasItsFifthConstant) {
  const ElasticConstants constants = vastus_lateralis();
  // Truth: G_cross = E_cross / (2 (1 + nu_cross)) and (C22 - C23) / 2, the shear of the plane of isotropy.
  const Matrix6 C = stiffness(constants);
  EXPECT_NEAR(constants.G23, 7.38e3 / (2 * 1.9012), 1e-9);
  EXPECT_NEAR((C(1, 1) - C(1, 2)) / 2, C(3, 3), 1e-9 * C(1, 1));
  EXPECT_EQ(C(4, 4), C(5, 5));
}

TEST(ElasticityAnalytic, IsIsotropicOnlyIfTurningChangesNothing) {
  const ElasticConstants isotropic = ElasticConstants::isotropic(10e3, 0.4);
  EXPECT_TRUE(isotropic.is_isotropic());
  EXPECT_FALSE(vastus_lateralis().is_isotropic());
  ElasticConstants nearly = isotropic;
  nearly.G12 *= 1 + 1e-10; // truth: the header's 1e-12 relative
  EXPECT_FALSE(nearly.is_isotropic());
  nearly.G12 = isotropic.G12 * (1 + 1e-14);
  EXPECT_TRUE(nearly.is_isotropic());

  test::RandomMaterials random(seed);
  const Matrix6 C = stiffness(isotropic);
  EXPECT_LT(largest(turned(C, random.rotation()) - C), 1e-12 * largest(C));
}

TEST(ElasticityAnalytic, TurnedStiffnessIsTheTurnedTensor) {
  SCOPED_TRACE(seed);
  test::RandomMaterials random(seed);
  for (int i = 0; i < draws; ++i) {
    const Matrix6 C = stiffness(random.valid_constants());
    const Eigen::Matrix3d axes = random.rotation();
    EXPECT_LT(largest(turned(C, axes) - turned_by_tensor(C, axes)), 1e-13 * largest(C));
  }
}

TEST(ElasticityAnalytic, TurnedComplianceIsTheInverse) {
  SCOPED_TRACE(seed);
  test::RandomMaterials random(seed);
  for (int i = 0; i < draws; ++i) {
    const ElasticConstants constants = random.valid_constants();
    const Eigen::Matrix3d axes = random.rotation();
    const Matrix6 S = turned_compliance(compliance(constants), axes);
    const Matrix6 C = turned(stiffness(constants), axes);
    EXPECT_LT(largest(S * C - Matrix6::Identity()), 1e-12 * largest(S) * largest(C));
  }
}

TEST(ElasticityAnalytic, TurnedStiffnessIsSpencersForm) {
  SCOPED_TRACE(seed);
  test::RandomMaterials random(seed);
  const Matrix6 C = stiffness(vastus_lateralis());
  for (int i = 0; i < draws; ++i) {
    const Eigen::Vector3d fibre = random.direction();
    Eigen::Matrix3d strain = Eigen::Matrix3d::Random();
    strain = (0.5 * (strain + strain.transpose())).eval();
    Eigen::Matrix<double, 6, 1> e; // engineering shears
    e << strain(0, 0), strain(1, 1), strain(2, 2), 2 * strain(1, 2), 2 * strain(0, 2), 2 * strain(0, 1);
    const Eigen::Matrix<double, 6, 1> s = turned(C, axes_from_fibre(fibre)) * e;
    Eigen::Matrix3d stress;
    stress << s(0), s(5), s(4), s(5), s(1), s(3), s(4), s(3), s(2);
    EXPECT_LT(largest(stress - spencer_stress(C, fibre, strain)), 1e-12 * largest(C));
  }
}

TEST(ElasticityAnalytic, AxesFromFibreAreTheSmallestTurn) {
  SCOPED_TRACE(seed);
  test::RandomMaterials random(seed);
  std::vector<Eigen::Vector3d> fibres{
      Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), -Eigen::Vector3d::UnitZ(), {-1, 1e-9, 2e-9},
      {-1, 1e-200, 0},          {-1, 1e-5, -1e-5},        {1e-160, 2e-160, 0},       {3e150, 0, 4e150}};
  for (int i = 0; i < draws; ++i)
    fibres.push_back(random.between(0.1, 10) * random.direction());
  for (const Eigen::Vector3d& fibre : fibres) {
    const Eigen::Vector3d unit = fibre.stableNormalized();
    const Eigen::Matrix3d axes = axes_from_fibre(fibre);
    EXPECT_LT(largest(axes.col(0) - unit), 1e-15) << fibre.transpose();
    EXPECT_LT(largest(axes.transpose() * axes - Eigen::Matrix3d::Identity()), 2e-15) << fibre.transpose();
    EXPECT_NEAR(axes.determinant(), 1, 1e-14);
    // Truth: a turn by t has the trace 1 + 2 cos t, and no turn that takes e_x to f is smaller than their
    // angle.
    EXPECT_NEAR(axes.trace(), 1 + 2 * unit.x(), 1e-14);
  }
  EXPECT_EQ(axes_from_fibre(Eigen::Vector3d(2, 0, 0)), Eigen::Matrix3d(Eigen::Matrix3d::Identity()));
  EXPECT_EQ(axes_from_fibre(Eigen::Vector3d(-2, 0, 0)),
            Eigen::Matrix3d(Eigen::Vector3d(-1, -1, 1).asDiagonal())); // truth: half a turn about e_z
}

TEST(PositiveEnergyOracle, InequalitiesAgreeWithEigenvalues) {
  SCOPED_TRACE(seed);
  test::RandomMaterials random(seed);
  int valid = 0, invalid = 0;
  for (int i = 0; i < 5000; ++i) {
    ElasticConstants constants = random.constants();
    if (i % 10 == 0)
      constants.G13 = -constants.G13;
    // Truth: the compliance scaled to a unit diagonal has only positive eigenvalues.
    Matrix6 S = compliance(constants);
    const Eigen::Matrix<double, 6, 1> scale = S.diagonal().cwiseAbs().cwiseSqrt().cwiseInverse();
    S = (scale.asDiagonal() * S * scale.asDiagonal()).eval();
    const double least = Eigen::SelfAdjointEigenSolver<Matrix6>(S).eigenvalues().minCoeff();
    if (std::abs(least) < 1e-6) {
      continue; // the two ways may round to different sides
    }
    (least > 0 ? valid : invalid) += 1;
    EXPECT_EQ(violated_inequalities(constants).empty(), least > 0)
        << "E " << constants.youngs_modulus[0] << " " << constants.youngs_modulus[1] << " "
        << constants.youngs_modulus[2] << " nu " << constants.nu12 << " " << constants.nu13 << " "
        << constants.nu23;
  }
  EXPECT_GT(valid, 500);
  EXPECT_GT(invalid, 500);
}

TEST(PositiveEnergyContract, EachViolatedInequalityIsNamedWithItsNumbers) {
  const std::vector<std::string> ratio = violated_inequalities({{1e3, 4e3, 4e3}, 0.9, 0, 0, 1e3, 1e3, 1e3});
  ASSERT_EQ(ratio.size(), 1U);
  EXPECT_EQ(ratio[0], "|nu12| < sqrt(E1/E2)  (0.9 < 0.5)"); // truth: the header's example
  const std::vector<std::string> moduli = violated_inequalities({{-5, 1e3, 0}, 0, 0, 0, -1, 1e3, 1e3});
  ASSERT_EQ(moduli.size(), 3U);
  EXPECT_EQ(moduli[0], "E1 > 0  (-5 > 0)");
  EXPECT_EQ(moduli[1], "E3 > 0  (0 > 0)");
  EXPECT_EQ(moduli[2], "G12 > 0  (-1 > 0)");
  EXPECT_FALSE(violated_inequalities({{NAN, 1, 1}, 0, 0, 0, 1, 1, 1}).empty());
  EXPECT_FALSE(violated_inequalities({{1, 1, 1}, NAN, 0, 0, 1, 1, 1}).empty());
  EXPECT_FALSE(violated_inequalities({{1, 1, 1}, 0, 0, 0, 1, INFINITY, 1}).empty());
}

TEST(PositiveEnergyContract, TheIncompressibleLimitIsRefused) {
  EXPECT_EQ(violated_inequalities(ElasticConstants::isotropic(1e3, 0.5)).size(), 1U);
  EXPECT_TRUE(violated_inequalities(ElasticConstants::isotropic(1e3, 0.4999)).empty());
  // Truth: nu_fibre = 1/2, nu_cross = 1 - E_cross / (2 E_fibre) leave the volume no way to change.
  const double nu_cross = 1 - 22.4 / (2 * 447);
  EXPECT_EQ(
      violated_inequalities(ElasticConstants::transversely_isotropic(447, 22.4, 3.87, 0.5, nu_cross)).size(),
      1U);
  EXPECT_TRUE(
      violated_inequalities(ElasticConstants::transversely_isotropic(447, 22.4, 3.87, 0.4, 0.5)).empty());
}

constexpr std::uint64_t reduced_seed = 20240608;

struct OffAxis {
  double degrees, E_x, eta, nu_xy;
};

/// Young's modulus, shear per stretch and contraction of a pull along x, the fibre at an angle in the xy
/// plane.
OffAxis pull(const ElasticConstants& constants, double degrees) {
  const double angle = degrees * std::numbers::pi / 180;
  const Eigen::Matrix3d axes = axes_from_fibre({std::cos(angle), std::sin(angle), 0});
  const Matrix6 S = turned_compliance(compliance(constants), axes);
  return {degrees, 1 / S(0, 0), S(0, 5) / S(0, 0), -S(0, 1) / S(0, 0)};
}

// Truth: closed form of off-axis tension (Lekhnitskii), tabulated; the last digit is rounded.
TEST(OffAxisTensionAnalytic, TablesOfTwoMuscles) {
  const auto expect_table = [](const ElasticConstants& constants, const std::vector<OffAxis>& table) {
    for (const OffAxis& expected : table) {
      const OffAxis found = pull(constants, expected.degrees);
      EXPECT_NEAR(found.E_x, expected.E_x, 0.00501) << expected.degrees;
      EXPECT_NEAR(found.eta, expected.eta, 0.000501) << expected.degrees;
      EXPECT_NEAR(found.nu_xy, expected.nu_xy, 0.000501) << expected.degrees;
    }
  };
  expect_table(ElasticConstants::transversely_isotropic(41.8, 7.38, 5.77, 0.5, 0.5), // vastus lateralis
               {{0, 41.80, 0, 0.500},
                {15, 32.50, -0.836, 0.368},
                {30, 20.03, -0.924, 0.202},
                {45, 12.95, -0.723, 0.122},
                {60, 9.46, -0.478, 0.095},
                {75, 7.85, -0.236, 0.089},
                {90, 7.38, 0, 0.088}});
  // Softest near 45 degrees. nu_cross has no part in it.
  expect_table(ElasticConstants::transversely_isotropic(447, 22.4, 3.87, 0.47, 0.5),
               {{0, 447, 0, 0.470},
                {15, 55.05, -3.079, 0.778},
                {30, 19.19, -1.223, 0.774},
                {45, 13.19, -0.280, 0.705},
                {60, 13.64, 0.368, 0.550},
                {75, 18.22, 0.633, 0.258},
                {90, 22.40, 0, 0.024}});
}

TEST(OffAxisTensionAnalytic, ClosedFormAtAnyAngle) {
  const double E1 = 447, E2 = 22.4, G = 3.87, nu = 0.4;
  const ElasticConstants constants = ElasticConstants::transversely_isotropic(E1, E2, G, nu, 0.5);
  const Matrix6 C = stiffness(constants);
  for (double degrees = 0; degrees <= 180; degrees += 7) {
    const double angle = degrees * std::numbers::pi / 180;
    const double c2 = std::pow(std::cos(angle), 2), s2 = std::pow(std::sin(angle), 2);
    // Truth: 1/E_x = c^4/E1 + (1/G12 - 2 nu12/E1) s^2 c^2 + s^4/E2.
    const double expected = 1 / (c2 * c2 / E1 + (1 / G - 2 * nu / E1) * s2 * c2 + s2 * s2 / E2);
    EXPECT_NEAR(pull(constants, degrees).E_x, expected, 1e-12 * expected);
    // Truth: eta = E_x [(2/E1 + 2 nu12/E1 - 1/G12) s c^3 - (2/E2 + 2 nu12/E1 - 1/G12) s^3 c],
    // nu_xy = -E_x [(1/E1 + 1/E2 - 1/G12) s^2 c^2 - nu12/E1 (s^4 + c^4)].
    const double sc = std::sin(angle) * std::cos(angle);
    const double eta =
        expected * sc * ((2 / E1 + 2 * nu / E1 - 1 / G) * c2 - (2 / E2 + 2 * nu / E1 - 1 / G) * s2);
    const double nu_xy = -expected * ((1 / E1 + 1 / E2 - 1 / G) * s2 * c2 - nu / E1 * (s2 * s2 + c2 * c2));
    EXPECT_NEAR(pull(constants, degrees).eta, eta, 1e-10);
    EXPECT_NEAR(pull(constants, degrees).nu_xy, nu_xy, 1e-10);
    const Eigen::Matrix3d axes = axes_from_fibre({std::cos(angle), std::sin(angle), 0});
    const Eigen::MatrixXd bar = reduced_stiffness(turned(C, axes), 1, PlaneAssumption::strain);
    ASSERT_EQ(bar.size(), 1);
    EXPECT_NEAR(bar(0, 0), expected, 1e-11 * expected);
  }
}

TEST(ReducedStiffnessAnalytic, PlaneStressHasTheKnownEntries) {
  const ElasticConstants c{{20e3, 9e3, 5e3}, 0.3, 0.2, 0.25, 4e3, 3e3, 2e3};
  const Eigen::MatrixXd Q = reduced_stiffness(stiffness(c), 2, PlaneAssumption::stress);
  // Truth: Q11 = E1/(1 - nu12 nu21), Q22 = E2/(..), Q12 = nu12 E2/(..), Q66 = G12 (classical laminate
  // theory).
  const double rest = 1 - c.nu12 * c.nu12 * 9e3 / 20e3;
  Eigen::Matrix3d expected;
  expected << 20e3 / rest, 0.3 * 9e3 / rest, 0, 0.3 * 9e3 / rest, 9e3 / rest, 0, 0, 0, 4e3;
  ASSERT_EQ(Q.rows(), 3);
  EXPECT_LT(largest(Q - expected), 1e-11 * 20e3);
}

TEST(ReducedStiffnessAnalytic, PlaneStressOfATurnedMaterialLeavesNoStressAcross) {
  SCOPED_TRACE(reduced_seed);
  test::RandomMaterials random(reduced_seed);
  for (int i = 0; i < draws; ++i) {
    const Matrix6 C = turned(stiffness(random.valid_constants()), random.rotation());
    const Eigen::MatrixXd Q = reduced_stiffness(C, 2, PlaneAssumption::stress);
    // Truth: with in-plane strain e and free strains f across, minimal energy means no stress across:
    // C_ff f = -C_fe e; what is left is the Schur complement.
    constexpr std::array<Eigen::Index, 3> in{0, 1, 5}, across{2, 3, 4};
    const Eigen::Matrix3d schur =
        C(in, in) -
        C(in, across) * Eigen::Matrix3d(C(across, across)).fullPivLu().solve(Eigen::Matrix3d(C(across, in)));
    EXPECT_LT(largest(Q - schur), 1e-10 * largest(C));
  }
}

TEST(ReducedStiffnessAnalytic, PlaneStrainAndThreeDimensionsKeepTheEntries) {
  test::RandomMaterials random(reduced_seed);
  const Matrix6 C = turned(stiffness(random.valid_constants()), random.rotation());
  const Eigen::MatrixXd plane = reduced_stiffness(C, 2, PlaneAssumption::strain);
  constexpr std::array<Eigen::Index, 3> in{0, 1, 5}; // truth: order xx, yy, xy; strains across are zero
  EXPECT_EQ(largest(plane - C(in, in)), 0);
  EXPECT_EQ(largest(reduced_stiffness(C, 3, PlaneAssumption::strain) - C), 0);
}

// Where matter fails: what is read, and the limits that follow.

Damage damage_at(const std::array<double, 3>& stretch) {
  Damage damage;
  damage.stretch = stretch;
  return damage;
}

// Truth: the singular values of the deformations themselves.
TEST(DamageAnalytic, NoDirectionIsDrawnOutFurtherThanMatterBears) {
  for (const double bears : {1.08, 1.462, 1.727}) {
    const NeighbourLimits limits = limits_before_failure(damage_at({bears, bears, bears}));
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_EQ(limits.stretch[a], bears);
      Eigen::Matrix3d squeezed = Eigen::Vector3d::Constant(1 / std::sqrt(limits.compress[a])).asDiagonal();
      squeezed(static_cast<int>(a), static_cast<int>(a)) = limits.compress[a];
      EXPECT_NEAR(squeezed.determinant(), 1, 1e-14) << "it keeps its volume";
      EXPECT_NEAR(Eigen::JacobiSVD<Eigen::Matrix3d>(squeezed).singularValues()(0), bears, 1e-14);
      for (std::size_t b = 0; b < 3; ++b) {
        if (a == b)
          continue;
        Eigen::Matrix3d sheared = Eigen::Matrix3d::Identity();
        sheared(static_cast<int>(b), static_cast<int>(a)) = limits.shear[a][b];
        EXPECT_NEAR(Eigen::JacobiSVD<Eigen::Matrix3d>(sheared).singularValues()(0), bears, 1e-14);
      }
    }
  }
}

// Truth: the definition, by hand.
TEST(DamageAnalytic, TheWeakerDirectionDecides) {
  const NeighbourLimits limits = limits_before_failure(damage_at({2, 1.25, 4}));
  EXPECT_EQ(limits.stretch, (std::array{2.0, 1.25, 4.0}));
  EXPECT_DOUBLE_EQ(limits.shear[0][1], 1.25 - 0.8);
  EXPECT_DOUBLE_EQ(limits.shear[1][0], 1.25 - 0.8);
  EXPECT_DOUBLE_EQ(limits.shear[0][2], 2 - 0.5);
  EXPECT_DOUBLE_EQ(limits.compress[0], 0.64); // 1 / 1.25^2
  EXPECT_DOUBLE_EQ(limits.compress[1], 0.25);
  EXPECT_DOUBLE_EQ(limits.compress[2], 0.64);
}

std::optional<Damage> damage_of(const std::string& text) {
  const toml::table document = parse_toml(text, "t.toml");
  FaultList faults("t.toml");
  TableReader table(document, "", faults, "damage");
  auto damage = read_damage(table);
  table.finish();
  faults.throw_if_any();
  return damage;
}

TEST(DamageContract, WhatIsKnownIsTakenAsItIs) {
  const auto damage = damage_of("stretch = [1.5, 1.8, 1.9]\ncompress = 0.6\nshear = 0.7\nof = \"a\"\n"
                                "source = \"b\"\nverified = true\n");
  ASSERT_TRUE(damage);
  EXPECT_TRUE(damage->verified);
  const NeighbourLimits limits = limits_before_failure(*damage);
  EXPECT_EQ(limits.stretch, (std::array{1.5, 1.8, 1.9}));
  EXPECT_EQ(limits.compress, (std::array{0.6, 0.6, 0.6}));
  EXPECT_EQ(limits.shear[2][0], 0.7);
  EXPECT_FALSE(damage_of("stretch = 1.5\n")->verified) << "unless it says so";
}

TEST(DamageContract, EveryFaultIsTold) {
  const auto faults = [](std::string_view text) { return test::faults_of(text, read_damage, "damage"); };
  EXPECT_EQ(faults("shear = 0.5\n").size(), 1u) << "no stretch";
  EXPECT_EQ(faults("stretch = 1\n").size(), 1u) << "what fails at rest";
  EXPECT_EQ(faults("stretch = [1.2, 0.9, 1.1]\n").size(), 1u);
  EXPECT_EQ(faults("stretch = 1.2\ncompress = 1.5\nshear = -1\nverified = 1\ncause = 2\n").size(), 4u);
}

} // namespace
} // namespace maille
