#include "maille/materials/elasticity.hpp"
#include "materials/random_materials.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

namespace maille {
namespace {

constexpr std::uint64_t seed = 20240608;
constexpr int draws = 200;

double largest(const Eigen::MatrixXd& matrix) {
  return matrix.cwiseAbs().maxCoeff();
}

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

} // namespace

TEST(OffAxisTensionAnalytic, VastusLateralisTable) {
  // Truth: closed form of off-axis tension (Lekhnitskii), tabulated for E 41.8, 7.38, G 5.77 kPa, nu 0.5; the
  // last digit is rounded.
  const ElasticConstants constants = ElasticConstants::transversely_isotropic(41.8, 7.38, 5.77, 0.5, 0.5);
  for (const OffAxis& expected :
       {OffAxis{0, 41.80, 0, 0.500}, OffAxis{15, 32.50, -0.836, 0.368}, OffAxis{30, 20.03, -0.924, 0.202},
        OffAxis{45, 12.95, -0.723, 0.122}, OffAxis{60, 9.46, -0.478, 0.095}, OffAxis{75, 7.85, -0.236, 0.089},
        OffAxis{90, 7.38, 0, 0.088}}) {
    const OffAxis found = pull(constants, expected.degrees);
    EXPECT_NEAR(found.E_x, expected.E_x, 0.00501) << expected.degrees;
    EXPECT_NEAR(found.eta, expected.eta, 0.000501) << expected.degrees;
    EXPECT_NEAR(found.nu_xy, expected.nu_xy, 0.000501) << expected.degrees;
  }
}

TEST(OffAxisTensionAnalytic, TableOfAMuscleSoftestBetweenItsAxes) {
  // Truth: the same for E 447, 22.4, G 3.87 kPa, nu 0.47: softest near 45 degrees. nu_cross has no part in
  // it.
  const ElasticConstants constants = ElasticConstants::transversely_isotropic(447, 22.4, 3.87, 0.47, 0.5);
  for (const OffAxis& expected :
       {OffAxis{0, 447, 0, 0.470}, OffAxis{15, 55.05, -3.079, 0.778}, OffAxis{30, 19.19, -1.223, 0.774},
        OffAxis{45, 13.19, -0.280, 0.705}, OffAxis{60, 13.64, 0.368, 0.550}, OffAxis{75, 18.22, 0.633, 0.258},
        OffAxis{90, 22.40, 0, 0.024}}) {
    const OffAxis found = pull(constants, expected.degrees);
    EXPECT_NEAR(found.E_x, expected.E_x, 0.00501) << expected.degrees;
    EXPECT_NEAR(found.eta, expected.eta, 0.000501) << expected.degrees;
    EXPECT_NEAR(found.nu_xy, expected.nu_xy, 0.000501) << expected.degrees;
  }
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
  SCOPED_TRACE(seed);
  test::RandomMaterials random(seed);
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
  test::RandomMaterials random(seed);
  const Matrix6 C = turned(stiffness(random.valid_constants()), random.rotation());
  const Eigen::MatrixXd plane = reduced_stiffness(C, 2, PlaneAssumption::strain);
  constexpr std::array<Eigen::Index, 3> in{0, 1, 5}; // truth: order xx, yy, xy; strains across are zero
  EXPECT_EQ(largest(plane - C(in, in)), 0);
  EXPECT_EQ(largest(reduced_stiffness(C, 3, PlaneAssumption::strain) - C), 0);
}

} // namespace maille
