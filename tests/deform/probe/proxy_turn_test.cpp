#include "maille/deform/probe/touch.hpp"
#include "probe/allowed_twist.hpp"

#include "support/dice.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace maille::deform {
namespace {

using tests::Dice;

RigidShape solid(const Index3& size) {
  return {
      size, {1, 1, 1}, std::vector<std::uint8_t>(static_cast<std::size_t>(size[0] * size[1] * size[2]), 1)};
}

Pose at(const Eigen::Vector3d& position) {
  return Pose{.position = position};
}

Eigen::Matrix3d turned(double angle, const Eigen::Vector3d& axis) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

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
      place = {dice.direction(), dice.between(1, 6) * dice.direction(), dice.between(0, 0.01)};
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

// Analytic: a plate in a slot two cells high, which a hand turns by 40 degrees with a tilt that the slot
// refuses. It turns all the same, and tilts no further than the slot lets it.
TEST(ProxyTurnAnalytic, ATiltThatIsRefusedDoesNotStopTheTurn) {
  RigidWorld world({40, 40, 30}, {1, 1, 1});
  world.add(solid({40, 40, 10}), {});
  world.add(solid({40, 40, 10}), at({0, 0, 12}));
  const Surroundings slot(&world.map(), {1, 1, 1});
  const RigidShape plate = solid({11, 11, 1});
  Proxy proxy(plate, at({20, 20, 11}));
  const double angle = 40 * std::acos(-1.0) / 180;
  for (int tick = 1; tick <= 40; ++tick) {
    Pose hand = at({20, 20, 11});
    hand.rotation = turned(0.35 * tick / 40, Eigen::Vector3d::UnitX()) *
                    turned(angle * tick / 40, Eigen::Vector3d::UnitZ());
    proxy.follow(slot, hand);
    ASSERT_EQ(slot.n_inside(plate, proxy.pose()), 0) << tick;
  }
  const Eigen::Matrix3d rotation = proxy.pose().rotation;
  EXPECT_NEAR(std::atan2(rotation(1, 0), rotation(0, 0)), angle, 0.05);
  EXPECT_LT(std::acos(rotation(2, 2)), 2.0 / 5); // the slot's height over the plate's half
  EXPECT_TRUE(proxy.is_turn_blocked());
}

// Analytic: a turned box comes to a column of one cell that lies between its voxels' middles: what it meets is
// the column's middle, against the box's own face.
TEST(ProxyTurnAnalytic, ATurnedBoxIsKeptOffByItsOwnFace) {
  RigidWorld world({40, 40, 40}, {1, 1, 1});
  world.add(solid({1, 1, 40}), at({20, 20, 0}));
  const Surroundings column(&world.map(), {1, 1, 1});
  int n_of_the_box = 0;
  for (int step = 0; step < 16; ++step) {
    Pose hand = at({27, 20.2 + 0.05 * step, 20});
    hand.rotation = turned(0.4, Eigen::Vector3d::UnitZ());
    const RigidShape box = solid({7, 7, 7});
    Proxy proxy(box, hand);
    hand.position[0] = 22;
    proxy.follow(column, hand);
    ASSERT_FALSE(proxy.constraints().empty());
    const Obstacle& met = proxy.constraints()[0].obstacle;
    if ((met.normal - hand.rotation.col(0)).norm() > 1e-9)
      continue; // a voxel's middle came to the cell's face
    ++n_of_the_box;
    EXPECT_NEAR(met.point[0], 20.5, 1e-9);
    EXPECT_NEAR(met.point[1], 20.5, 1e-9);
    // On the face, to what the contact is found to.
    const Eigen::Vector3d in = proxy.pose().rotation.transpose() * (met.point - proxy.middle());
    EXPECT_LT(in[0], -3.5 + 0.5);
  }
  EXPECT_GT(n_of_the_box, 3);
}

} // namespace
} // namespace maille::deform
