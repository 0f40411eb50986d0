#include "probe/allowed_twist.hpp"

#include "support/dice.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <random>
#include <vector>

namespace maille::deform {
namespace {

using tests::Dice;

struct Place {
  Eigen::Vector3d normal, point;
  double gap = 0;
};

/// How far a place goes along its normal, by the velocity of its point.
double along(const Place& place, const Twist& twist, double arm) {
  const Eigen::Vector3d angle = twist.tail<3>() / arm;
  return place.normal.dot(twist.head<3>() + angle.cross(place.point));
}

// Oracle: very many twists tried; none that every place allows lies nearer to the wanted one.
TEST(AllowedTwistOracle, NoAllowedTwistIsNearer) {
  std::mt19937 random(4);
  Dice dice{random};
  int n_bound = 0;
  for (int round = 0; round < 200; ++round) {
    const double arm = dice.between(1, 5);
    std::vector<Place> places(static_cast<std::size_t>(dice.below(30)));
    TwistConstraints constraints(arm);
    for (Place& place : places) {
      place = {dice.direction(), dice.between(1, 6) * dice.direction(), dice.between(0, 1e-3)};
      // Far arms ask for tiny turns only, so that straight and bent ways hardly differ.
      constraints.add(place.normal, place.point, place.gap);
    }
    Twist wanted;
    wanted << 1e-3 * dice.direction(), 1e-3 * dice.direction();
    const Twist allowed = constraints.allowed(wanted, 0);
    double bend = 0; // an arc's, at most, with a fifth more for what it is counted in with
    for (const Place& place : places) {
      EXPECT_GE(along(place, allowed, arm), -place.gap - 1e-10);
      bend = std::max(bend, 1e-6 * place.point.norm() / (arm * arm) * 4);
    }
    const double distance = (allowed - wanted).norm();
    n_bound += distance > 1e-6;
    for (int trial = 0; trial < 300; ++trial) {
      Twist other;
      other << dice.direction(), dice.direction();
      other = allowed + dice.between(0, 1e-3) * other;
      bool is_allowed = true;
      for (const Place& place : places)
        is_allowed = is_allowed && along(place, other, arm) >= -place.gap;
      if (is_allowed) {
        EXPECT_GE((other - wanted).norm(), distance - 30 * bend) << round;
      }
    }
  }
  EXPECT_GT(n_bound, 100); // else nothing was tested
}

// Analytic: one place on a floor beside the middle. The multiplier is that of the one row, so the shift and
// the tilt share what is refused as 1 to the square of the place's arm over the arm.
TEST(AllowedTwistAnalytic, AShiftThatIsRefusedTiltsTheTool) {
  constexpr double arm = 2, beside = 4, down = 1e-6;
  TwistConstraints constraints(arm);
  constraints.add(Eigen::Vector3d::UnitZ(), {beside, 0, 0}, 0);
  Twist wanted = Twist::Zero();
  wanted[2] = -down;
  const Twist allowed = constraints.allowed(wanted, 0);
  const double share = (beside / arm) * (beside / arm);
  EXPECT_NEAR(allowed[2], -down * share / (1 + share), 1e-10);
  EXPECT_NEAR(allowed[4], -down * (beside / arm) / (1 + share), 1e-10); // the place goes up about y
}

} // namespace
} // namespace maille::deform
