// Where matter fails: what is read, and the limits that follow.
#include "materials/read_helpers.hpp"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace maille {
namespace {

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
  TableReader table(document, "", faults);
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
  const auto faults = [](std::string_view text) {
    return test::faults_of(text, [](TableReader& table) { read_damage(table); });
  };
  EXPECT_EQ(faults("shear = 0.5\n").size(), 1u) << "no stretch";
  EXPECT_EQ(faults("stretch = 1\n").size(), 1u) << "what fails at rest";
  EXPECT_EQ(faults("stretch = [1.2, 0.9, 1.1]\n").size(), 1u);
  EXPECT_EQ(faults("stretch = 1.2\ncompress = 1.5\nshear = -1\nverified = 1\ncause = 2\n").size(), 4u);
}

} // namespace
} // namespace maille
