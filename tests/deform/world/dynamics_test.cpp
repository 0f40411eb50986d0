/// Worlds in which time passes: falls, impacts, momentum and energy.

#include "maille/deform/world/world.hpp"
#include "support/kit.hpp"

#include <Eigen/Geometry>

namespace maille::deform {
namespace {

constexpr double mm = 1e-3, g = 9.81;

std::string world_text(const std::string& cells, const std::string& dynamics) {
  return "[world]\ncells = [" + cells + "]\nspacing = \"1 mm\"\ncontact = \"surfaces\"\ndynamics = { " +
         dynamics + " }\n";
}

std::string object(const std::string& name, const std::string& kind, const std::string& shape,
                   const std::string& cells, const std::string& position, const std::string& more = "") {
  return fmt::format("[[object]]\nname = \"{}\"\nkind = \"{}\"\nshape = \"{}\"\ncells = [{}]\nposition = "
                     "[{}]\n{}\n",
                     name, kind, shape, cells, position, more);
}

FrameResult pass(World& world, double seconds, std::span<const Drive> drives = {}) {
  FrameBudget budget;
  budget.frame_seconds = seconds;
  return world.advance(drives, budget);
}

struct Sums {
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
  double angular = 0; ///< about the origin, along z
  static Sums of(const World& world, double inertia_over_mass) {
    Sums sums;
    for (int object = 0; object < world.n_objects(); ++object) {
      const ObjectMotion motion = world.motion(object);
      sums.momentum += motion.mass * motion.velocity;
      sums.angular += motion.mass * motion.centre.cross(motion.velocity)[2] +
                      motion.mass * inertia_over_mass * motion.spin[2];
    }
    return sums;
  }
};

// Analytic: y = y0 - g t^2 / 2, and with drag the exponential approach to g / damping.
TEST(DynamicsAnalytic, AFallFollowsTheClosedForm) {
  for (const double damping : {0.0, 8.0}) {
    World world(parse_world_scene(
        world_text("20, 200", fmt::format("gravity = [0, \"-9.81 m/s^2\"], damping = {}", damping)) +
        object("block", "rigid", "box", "4, 4", "\"8 mm\", \"190 mm\"", "velocity = [0.01, 0.2]")));
    const Eigen::Vector3d start = world.motion(0).centre;
    EXPECT_NEAR(world.motion(0).mass, 1000 * 16e-6, 1e-12);
    for (int frame = 1; frame <= 10; ++frame) {
      ASSERT_EQ(pass(world, 0.01).status, Status::done);
      const double t = 0.01 * frame, gone = damping == 0 ? t : -std::expm1(-damping * t) / damping;
      const double fall = damping == 0 ? -g * t * t / 2 : -g * (t - gone) / damping;
      EXPECT_NEAR(world.motion(0).centre[1], start[1] + 0.2 * gone + fall, 1e-12);
      EXPECT_NEAR(world.motion(0).centre[0], start[0] + 0.01 * gone, 1e-12);
    }
  }
}

// Analytic: after an impact a ball rises to restitution^2 of the height that it fell from.
TEST(DynamicsAnalytic, ABallRisesByItsRestitution) {
  for (const double restitution : {0.0, 0.5, 1.0}) {
    World world(parse_world_scene(
        world_text("20, 60", fmt::format("gravity = [0, \"-9.81 m/s^2\"], restitution = {}", restitution)) +
        object("ball", "rigid", "ellipsoid", "8, 8", "\"6 mm\", \"40 mm\"")));
    const double height = 40 * mm, fall = std::sqrt(2 * height / g);
    ASSERT_EQ(pass(world, fall + 1e-4).status, Status::done); // just after the impact
    const double speed = world.motion(0).velocity[1];
    EXPECT_NEAR(speed, restitution * std::sqrt(2 * g * height) - (restitution > 0 ? g * 1e-4 : 0), 2e-4);
    if (restitution > 0) {
      ASSERT_EQ(pass(world, speed / g).status, Status::done); // to where it stands still
    }
    EXPECT_NEAR(world.motion(0).centre[1] - 4 * mm, restitution * restitution * height, 1e-3 * height);
    EXPECT_NEAR(world.motion(0).velocity[0], 0, 1e-12);
    EXPECT_EQ(world.n_penetrations(), 0);
  }
}

// Analytic: the last ball leaves as the first came; momentum is kept to rounding, no energy comes up.
TEST(DynamicsAnalytic, NewtonsCradleHandsAMovementOn) {
  std::string text = world_text("100, 20", "restitution = 1");
  for (int ball = 0; ball < 5; ++ball)
    text += object(fmt::format("ball{}", ball), "rigid", "ellipsoid", "8, 8",
                   fmt::format("\"{:.4f} mm\", \"6 mm\"", ball == 0 ? 5.0 : 20 + 8.0001 * ball),
                   ball == 0 ? "velocity = [0.5, 0]" : "");
  World world(parse_world_scene(text));
  const double momentum = world.motion(0).mass * 0.5, energy = world.energy();
  for (int frame = 0; frame < 10; ++frame) {
    ASSERT_EQ(pass(world, 0.005).status, Status::done);
    const Sums sums = Sums::of(world, 0);
    EXPECT_NEAR((sums.momentum - Eigen::Vector3d(momentum, 0, 0)).norm(), 0, 1e-10 * momentum);
    EXPECT_LE(world.energy(), energy * (1 + 1e-6));
  }
  EXPECT_NEAR(world.energy(), energy, 1e-6 * energy);
  for (int ball = 0; ball < 5; ++ball) {
    EXPECT_NEAR(world.motion(ball).velocity[0], ball == 4 ? 0.5 : 0, 1e-6);
    EXPECT_NEAR(world.motion(ball).velocity[1], 0, 1e-9);
  }
}

// Analytic: a plank hit off its middle turns; momentum, angular momentum and energy are kept.
TEST(DynamicsAnalytic, APlankHitAtItsEndTurns) {
  World world(parse_world_scene(
      world_text("60, 60", "restitution = 1") +
      object("plank", "rigid", "box", "4, 4", "\"10 mm\", \"12 mm\"", "velocity = [0.4, 0]") +
      object("other", "rigid", "box", "4, 4", "\"24 mm\", \"14.5 mm\"")));
  const double inertia_over_mass = 32e-6 / 12;
  const Sums before = Sums::of(world, inertia_over_mass);
  const double energy = world.energy();
  for (int frame = 0; frame < 6; ++frame)
    ASSERT_EQ(pass(world, 0.01).status, Status::done);
  const Sums after = Sums::of(world, inertia_over_mass);
  EXPECT_NEAR((after.momentum - before.momentum).norm(), 0, 1e-10 * before.momentum.norm());
  EXPECT_NEAR(after.angular, before.angular, 1e-10 * std::abs(before.angular));
  EXPECT_NEAR(world.energy(), energy, 1e-6 * energy);
  EXPECT_GT(std::abs(world.motion(1).spin[2]), 10);
  EXPECT_GT(world.motion(1).velocity[0], 0.1);
}

// Analytic: what lies stays, and presses with its weight.
TEST(DynamicsAnalytic, AStackLiesStill) {
  World world(parse_world_scene(world_text("20, 30", "gravity = [0, \"-9.81 m/s^2\"], restitution = 0.5") +
                                object("lower", "rigid", "box", "6, 4", "\"6 mm\", \"0.0001 mm\"") +
                                object("upper", "rigid", "box", "4, 4", "\"7 mm\", \"4.0002 mm\"")));
  FrameResult result;
  for (int frame = 0; frame < 10; ++frame)
    result = pass(world, 0.02);
  ASSERT_EQ(result.status, Status::done) << result.message;
  EXPECT_NEAR(world.motion(0).centre[1], 2 * mm, 1e-3 * mm);
  EXPECT_NEAR(world.motion(1).centre[1], 6 * mm, 1e-3 * mm);
  double on_floor = 0, on_lower = 0;
  for (const WorldContact& contact : result.contacts) {
    if (contact.object == 0 && contact.other < 0)
      on_floor += contact.force[1];
    if (contact.object == 1 && contact.other == 0)
      on_lower += contact.force[1];
  }
  EXPECT_NEAR(on_floor, 40e-3 * g, 1e-6);
  EXPECT_NEAR(on_lower, 16e-3 * g, 1e-6);
}

// Analytic: a hand that moves at a constant speed pushes what is free along, and stops at a wall.
TEST(DynamicsAnalytic, AHandPushesAndStopsAtAWall) {
  World world(parse_world_scene(world_text("40, 20", "restitution = 0") +
                                object("hand", "rigid", "box", "4, 8", "\"2 mm\", \"6 mm\"") +
                                object("block", "rigid", "box", "6, 6", "\"10 mm\", \"7 mm\"")));
  Drive drive;
  drive.motion.by = {4 * mm, 0, 0};
  FrameResult result;
  for (int frame = 0; frame < 3; ++frame)
    result = pass(world, 0.01, {&drive, 1});
  ASSERT_EQ(result.status, Status::done) << result.message;
  EXPECT_NEAR(world.motion(1).velocity[0], 0.4, 1e-6);
  EXPECT_NEAR(world.motion(1).centre[0], 21 * mm, 1e-3 * mm);
  for (int frame = 0; frame < 6; ++frame)
    result = pass(world, 0.01, {&drive, 1});
  EXPECT_EQ(result.status, Status::clamped);
  EXPECT_LT(world.motion(1).centre[0], 37 * mm);
  EXPECT_GT(world.motion(1).centre[0], 36.9 * mm);
  EXPECT_EQ(world.n_penetrations(), 0);
}

} // namespace
} // namespace maille::deform
