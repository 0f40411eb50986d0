#include "maille/materials/material.hpp"
#include "materials/random_materials.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <numbers>

namespace maille {
namespace {

constexpr std::uint64_t seed = 77;
constexpr int draws = 200;

NeighbourLimits nine_different_limits() {
  return {{1.1, 1.2, 1.3}, {0.9, 0.8, 0.7}, {{{0, 0.12, 0.13}, {0.21, 0, 0.23}, {0.31, 0.32, 0}}}};
}

void expect_near(const NeighbourLimits& found, const NeighbourLimits& expected, double tolerance) {
  for (std::size_t a = 0; a < 3; ++a) {
    EXPECT_NEAR(found.stretch[a], expected.stretch[a], tolerance) << a;
    EXPECT_NEAR(found.compress[a], expected.compress[a], tolerance) << a;
    for (std::size_t b = 0; b < 3; ++b) {
      EXPECT_NEAR(found.shear[a][b], expected.shear[a][b], tolerance) << a << b;
    }
  }
}

} // namespace

TEST(TurnedLimitsAnalytic, NoTurnChangesNothing) {
  EXPECT_EQ(turned(nine_different_limits(), Eigen::Matrix3d::Identity()), nine_different_limits());
}

TEST(TurnedLimitsAnalytic, QuarterTurnsPermute) {
  const NeighbourLimits limits = nine_different_limits();
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const Eigen::Matrix3d quarter =
        Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::Unit(axis)).toRotationMatrix();
    // Truth: object axis a is, up to sign, the material axis p[a]; all limits are even in the sign.
    std::array<std::size_t, 3> p{0, 1, 2};
    std::swap(p[(static_cast<std::size_t>(axis) + 1) % 3], p[(static_cast<std::size_t>(axis) + 2) % 3]);
    NeighbourLimits expected;
    for (std::size_t a = 0; a < 3; ++a) {
      expected.stretch[a] = limits.stretch[p[a]];
      expected.compress[a] = limits.compress[p[a]];
      for (std::size_t b = 0; b < 3; ++b) {
        expected.shear[a][b] = limits.shear[p[a]][p[b]];
      }
    }
    expect_near(turned(limits, quarter), expected, 1e-15);
  }
}

TEST(TurnedLimitsAnalytic, AThirdOfATurnAboutTheDiagonalCyclesTheAxes) {
  const Eigen::Matrix3d third =
      Eigen::AngleAxisd(2 * std::numbers::pi / 3, Eigen::Vector3d::Ones().normalized()).toRotationMatrix();
  // Truth: material axes 1, 2, 3 lie along object y, z, x, so x, y, z see 3, 1, 2. A turn that is not its own
  // inverse tells rows from columns.
  const NeighbourLimits expected{
      {1.3, 1.1, 1.2}, {0.7, 0.9, 0.8}, {{{0, 0.31, 0.32}, {0.13, 0, 0.12}, {0.23, 0.21, 0}}}};
  expect_near(turned(nine_different_limits(), third), expected, 1e-15);
}

TEST(TurnedLimitsAnalytic, EighthTurnAverages) {
  const Eigen::Matrix3d eighth =
      Eigen::AngleAxisd(std::numbers::pi / 4, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const NeighbourLimits found = turned(nine_different_limits(), eighth);
  // Truth: the header's formula by hand, with R_xi^2 = R_yi^2 = 1/2 for i = 1, 2.
  EXPECT_NEAR(found.stretch[0], 1.15, 1e-15);
  EXPECT_NEAR(found.stretch[2], 1.3, 1e-15);
  EXPECT_NEAR(found.compress[1], 0.85, 1e-15);
  EXPECT_NEAR(found.shear[0][1], (0.12 + 0.21) / 2, 1e-15);
  EXPECT_NEAR(found.shear[0][2], (0.13 + 0.23) / 2, 1e-15);
  EXPECT_NEAR(found.shear[2][1], (0.31 + 0.32) / 2, 1e-15);
}

TEST(TurnedLimitsAnalytic, EqualLimitsStayEqualAndLegalOnesLegal) {
  SCOPED_TRACE(seed);
  test::RandomMaterials random(seed);
  const NeighbourLimits rigid;
  const NeighbourLimits equal{
      {1.3, 1.3, 1.3}, {0.7, 0.7, 0.7}, {{{0, 0.3, 0.3}, {0.3, 0, 0.3}, {0.3, 0.3, 0}}}};
  for (int i = 0; i < draws; ++i) {
    const Eigen::Matrix3d axes = random.rotation();
    EXPECT_EQ(turned(equal, axes), equal); // to the last bit: no limit may leak through round-off
    EXPECT_EQ(turned(rigid, axes), rigid);
  }
}

TEST(LinkComplianceAnalytic, IsTheInverseModuliAlongTheAxes) {
  const ElasticConstants c{{20e3, 9e3, 5e3}, 0.3, 0.2, 0.25, 4e3, 3e3, 2e3};
  const LinkCompliance solid = link_compliance(stiffness(c));
  // Truth: a pull along axis a alone stretches by 1/E_a, a shear of the plane ab gives 1/G_ab.
  EXPECT_NEAR(solid.axial[0], 1 / 20e3, 1e-17);
  EXPECT_NEAR(solid.axial[1], 1 / 9e3, 1e-17);
  EXPECT_NEAR(solid.axial[2], 1 / 5e3, 1e-17);
  EXPECT_NEAR(solid.shear[0][1], 1 / 4e3, 1e-17);
  EXPECT_NEAR(solid.shear[2][0], 1 / 3e3, 1e-17);
  EXPECT_NEAR(solid.shear[1][2], 1 / 2e3, 1e-17);
  EXPECT_EQ(solid.shear[2][1], solid.shear[1][2]);

  const LinkCompliance plane = link_compliance(reduced_stiffness(stiffness(c), 2, PlaneAssumption::stress));
  EXPECT_NEAR(plane.axial[1], 1 / 9e3, 1e-17);
  EXPECT_NEAR(plane.shear[1][0], 1 / 4e3, 1e-17);
  EXPECT_EQ(plane.axial[2], 0);
  EXPECT_EQ(plane.shear[0][2], 0);

  const LinkCompliance bar = link_compliance(reduced_stiffness(stiffness(c), 1, PlaneAssumption::stress));
  EXPECT_NEAR(bar.axial[0], 1 / 20e3, 1e-17);
  EXPECT_EQ(bar.axial[1], 0);
}

} // namespace maille
