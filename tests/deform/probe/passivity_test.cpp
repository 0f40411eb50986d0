#include "maille/deform/probe/probe.hpp"

#include "maille/deform/probe/device.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace maille::deform {
namespace {

constexpr double period = 1e-3;

/// A device at one place: what moves it are forces.
RecordedMotion still(const Eigen::Vector3d& at) {
  return RecordedMotion({{0, Pose{.position = at}}});
}

struct Bounce {
  double begin_energy, end_energy, largest_energy;
  double least_observed;
};

/// A handle thrown at a wall of the given stiffness below z = 0, as a hand that lets go, for two seconds.
Bounce bounce(double stiffness, double damping, double wall_damping, bool two_walls) {
  SimulatedDevice device(still({0, 0, 1e-3}), {.mass = 0.1, .damping = damping}, period);
  device.set_velocity({0, 0, -0.5});
  PassivityObserver observer(damping, period, 0);
  Bounce result{device.kinetic_energy(), 0, 0, 0};
  double before = 0;
  for (int tick = 0; tick < 2000; ++tick) {
    const double z = device.read().position[2];
    double depth = std::max(-z, 0.0);
    if (two_walls && z > 2e-3)
      depth = 2e-3 - z;
    const double rate = depth != 0 && before != 0 ? (depth - before) / period : 0;
    before = depth;
    const Eigen::Vector3d force(0, 0, stiffness * depth + wall_damping * rate);
    device.write({observer.watched({0, 0, z}, force), {}});
    result.largest_energy = std::max(result.largest_energy, device.kinetic_energy());
  }
  result.end_energy = device.kinetic_energy();
  result.least_observed = observer.least_energy();
  return result;
}

// Analytic: Colgate and Brown's bound, b > K T / 2 + |B|.
TEST(PassivityAnalytic, TheBoundIsThatOfColgateAndBrown) {
  EXPECT_DOUBLE_EQ(largest_passive_stiffness(0.5, 0, 1e-3), 1000);
  EXPECT_DOUBLE_EQ(largest_passive_stiffness(0.5, 0.2, 1e-3), 600);
  EXPECT_DOUBLE_EQ(largest_passive_stiffness(0.5, 0.2, 0.5e-3), 1200); // twice as often: twice as stiff
  EXPECT_EQ(largest_passive_stiffness(0.5, 0.6, 1e-3), 0);
  EXPECT_TRUE(is_passive({.stiffness = 999}, 0.5, 1e-3));
  EXPECT_FALSE(is_passive({.stiffness = 1000}, 0.5, 1e-3));
}

// Analytic: within the bound no energy ever comes out of a wall; far beyond it, a handle between two walls is
// driven, which shows that the test can fail.
TEST(PassivityAnalytic, WallsWithinTheBoundGiveNoEnergy) {
  for (const double damping : {0.05, 0.5, 2.0})
    for (const double wall_damping : {0.0, 0.4 * damping}) {
      const double stiffness = 0.99 * largest_passive_stiffness(damping, wall_damping, period);
      for (const bool two_walls : {false, true}) {
        const Bounce within = bounce(stiffness, damping, wall_damping, two_walls);
        EXPECT_GE(within.least_observed, -1e-12) << damping << ' ' << wall_damping; // rounding of joules
        EXPECT_LE(within.largest_energy, within.begin_energy * (1 + 1e-12));
        // The device dissipates energy between the walls.
        EXPECT_LT(within.end_energy, 0.9 * within.begin_energy);
      }
    }
  const Bounce beyond = bounce(40 * largest_passive_stiffness(0.05, 0, period), 0.05, 0, true);
  EXPECT_LT(beyond.least_observed, -0.1 * beyond.begin_energy);
  EXPECT_GT(beyond.largest_energy, beyond.begin_energy);
}

// Analytic: the same of a spring that is moved to and fro as a hand may, whatever the path: energy in is
// never below 0.
TEST(PassivityAnalytic, NoPathDrawsEnergyFromAWallWithinTheBound) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const double damping = 0.3, stiffness = 0.999 * largest_passive_stiffness(damping, 0, period);
  double least_beyond = 0;
  for (int path = 0; path < 200; ++path) {
    PassivityObserver within(damping, period, 0), beyond(damping, period, 0);
    double z = 1e-3, v = 0;
    for (int tick = 0; tick < 500; ++tick) {
      v = 0.7 * v + 0.05 * normal(random);
      z += period * v;
      const Eigen::Vector3d force(0, 0, stiffness * std::max(-z, 0.0));
      within.watched({0, 0, z}, force);
      beyond.watched({0, 0, z}, 4 * force);
      ASSERT_GE(within.energy(), -1e-15);
    }
    least_beyond = std::min(least_beyond, beyond.least_energy());
  }
  EXPECT_LT(least_beyond, -1e-9); // four times as stiff does give energy: the bound says something
}

// Contract: stiffness that grows while it is pressed gives energy; the guard takes it back.
TEST(PassivityContract, TheGuardTakesBackWhatAStiffeningSpringGives) {
  const auto run = [](bool guarded) {
    SimulatedDevice device(still({0, 0, 1e-3}), {.mass = 0.1, .damping = 0.2}, period);
    device.set_velocity({0, 0, -0.2});
    PassivityObserver observer(0.2, period, 10);
    for (int tick = 0; tick < 1000; ++tick) {
      const double z = device.read().position[2];
      const double stiffness = device.velocity()[2] < 0 ? 50 : 380; // soft going in, stiff coming out
      const Eigen::Vector3d force(0, 0, stiffness * std::max(-z, 0.0));
      device.write({guarded ? observer.guarded({0, 0, z}, force) : observer.watched({0, 0, z}, force), {}});
    }
    return observer;
  };
  const auto left = run(false), guarded = run(true);
  EXPECT_LT(left.least_energy(), -1e-3); // more than half of what it was thrown with
  EXPECT_GT(guarded.least_energy(), 0.1 * left.least_energy());
  EXPECT_GT(guarded.taken_back(), 0);
}

} // namespace
} // namespace maille::deform
