#include "deform/probe/probe_scenes.hpp"
#include "maille/deform/probe/device.hpp"
#include "maille/deform/probe/probe.hpp"
#include "maille/deform/probe/servo_loop.hpp"
#include "support/kit.hpp"

#include <chrono>
#include <memory>

namespace maille::deform {
namespace {

Pose at(const Eigen::Vector3d& position) {
  return Pose{.position = position};
}

/// A floor of the lower ten layers and a wall from x = 20 on, in a world of millimetres.
struct Room {
  Room() : world({40, 40, 40}, {1e-3, 1e-3, 1e-3}) {
    const auto solid = [](const Index3& size) {
      return RigidShape(size, {1e-3, 1e-3, 1e-3},
                        std::vector<std::uint8_t>(std::size_t(size[0] * size[1] * size[2]), 1));
    };
    world.add(solid({40, 40, 10}), {});
    world.add(solid({20, 40, 30}), at({20e-3, 0, 10e-3}));
    surroundings = std::make_shared<Surroundings>(&world.map(), world.cell_size());
  }
  Proxy point(const Eigen::Vector3d& start) const { return {point_tool(world.cell_size()), at(start)}; }

  RigidWorld world;
  std::shared_ptr<const Surroundings> surroundings;
};

TEST(ProbeAnalytic, APlaneAndACornerDrawByTheirSprings) {
  const Room room;
  ProbeSettings settings;
  settings.coupling.stiffness = 300;
  Probe probe(room.surroundings, room.point({5e-3, 5e-3, 15e-3}), settings, 0.5);
  probe.tick(at({5e-3, 5e-3, 12e-3}));
  EXPECT_FALSE(probe.state().is_touching);
  EXPECT_EQ(probe.state().force.force, Eigen::Vector3d::Zero());
  // Analytic: stiffness times depth along the normal, nothing along the plane however the hand slides on it.
  probe.tick(at({7e-3, 6e-3, 8e-3}));
  EXPECT_LT((probe.state().force.force - Eigen::Vector3d(0, 0, 300 * 2e-3)).norm(), 1e-6);
  EXPECT_LT((probe.state().proxy - Eigen::Vector3d(7e-3, 6e-3, 10e-3)).norm(), 1e-9);
  // In the corner: both, and the energy of a spring to the corner.
  probe.tick(at({21e-3, 6e-3, 7e-3}));
  EXPECT_LT((probe.state().force.force - Eigen::Vector3d(-300 * 1e-3, 0, 300 * 3e-3)).norm(), 1e-5);
}

TEST(ProbeAnalytic, DampingActsAcrossAWallAndNeverDrawsIntoIt) {
  const Room room;
  ProbeSettings settings;
  settings.coupling = {.stiffness = 200, .damping = 0.3};
  settings.guard = false;
  Probe probe(room.surroundings, room.point({5e-3, 5e-3, 15e-3}), settings, 1);
  probe.tick(at({5e-3, 5e-3, 9e-3}));
  probe.tick(at({8e-3, 5e-3, 8.9e-3})); // 0.1 m/s in, 3 m/s along
  EXPECT_LT((probe.state().force.force - Eigen::Vector3d(0, 0, 200 * 1.1e-3 + 0.3 * 0.1)).norm(), 1e-6);
  probe.tick(at({8e-3, 5e-3, 9.9e-3})); // 1 m/s out: the damper would draw in
  EXPECT_GE(probe.state().force.force[2], 0);
}

// Analytic: a hand that comes off a ledge over a floor. The proxy falls by 10 mm at once; what is felt of
// that dies away with the time constant, never goes faster than that from tick to tick, and gives no energy.
TEST(ProbeAnalytic, AStepIsFeltOverATime) {
  constexpr double mm = 1e-3, stiffness = 300, easing = 50e-3;
  RigidWorld world({40, 40, 40}, {mm, mm, mm});
  const auto add = [&](const Index3& size, const Eigen::Vector3d& corner) {
    world.add(RigidShape(size, {mm, mm, mm},
                         std::vector<std::uint8_t>(std::size_t(size[0] * size[1] * size[2]), 1)),
              at(corner));
  };
  add({40, 40, 10}, {0, 0, 0});
  add({20, 40, 10}, {20 * mm, 0, 10 * mm});
  const auto around = std::make_shared<Surroundings>(&world.map(), world.cell_size());
  for (const bool is_eased : {true, false}) {
    ProbeSettings settings;
    settings.coupling.stiffness = stiffness;
    settings.easing = is_eased ? easing : 0;
    settings.guard = false;
    Probe probe(around, {point_tool(world.cell_size()), at({22 * mm, 9 * mm, 21 * mm})}, settings, 0.5);
    double largest_step = 0;
    Eigen::Vector3d before = Eigen::Vector3d::Zero();
    const auto tick = [&](double x, double z) {
      probe.tick(at({x * mm, 9 * mm, z * mm}));
      largest_step = std::max(largest_step, (probe.state().force.force - before).norm());
      before = probe.state().force.force;
    };
    for (int i = 0; i <= 260; ++i)
      tick(22, 21 - 0.05 * i); // to 12 mm below the ledge
    for (int i = 1; i <= 41; ++i)
      tick(22 - 0.05 * i, 8); // off it in the last tick
    const double way = 0.05;  // [mm] of the hand; the proxy went 10 mm down, and as far as the hand beside
    const double jump = std::hypot(10, way);
    if (!is_eased) {
      EXPECT_NEAR(largest_step, stiffness * jump * mm, 1e-3 * stiffness * jump * mm);
      continue;
    }
    for (int i = 1; i <= 200; ++i) {
      tick(19.95, 8);
      const double left = (jump - way) / jump * 10 * std::exp(-i * 1e-3 / easing);
      ASSERT_NEAR(probe.state().force.force[2], stiffness * (2 + left) * mm, 1e-4) << i;
    }
    EXPECT_LT(largest_step, stiffness * (10 * 1e-3 / easing + 2 * way) * mm);
    EXPECT_GE(probe.passivity().least_energy(), -1e-12);
  }
}

/// A block on a table without friction, pressed by a plate: a bar of stiffness E A / L = 30 N/m.
struct Block {
  Block() {
    scene = test::free_block({6, 4, 8});
    surface = std::make_shared<BodySurface>(scene, Displacement(), Pose());
    solver.emplace(scene, surface, 10e-3);
    newest = solver->estimate();
    surroundings = std::make_shared<Surroundings>(nullptr, Vec3{1e-3, 1e-3, 1e-3}, std::vector{surface});
  }
  /// Answers at once.
  void link(Probe& probe) {
    probe.link(0, {[this](const ContactSite& site) { newest = solver->solve(site); },
                   [this]() -> const ContactStiffness& { return newest; }, false});
  }

  Scene scene;
  std::shared_ptr<const BodySurface> surface;
  std::optional<ContactSolver> solver;
  ContactStiffness newest;
  std::shared_ptr<const Surroundings> surroundings;
};

TEST(ProbeAnalytic, AnElasticBlockIsFeltAsItsStiffness) {
  Block block;
  const double of_block = 10e3 * (6e-3 * 4e-3) / 8e-3; // E A / L
  for (const ForceRule rule : {ForceRule::reaction, ForceRule::coupling}) {
    ProbeSettings settings;
    settings.coupling.stiffness = 400;
    settings.rule = rule;
    Probe probe(block.surroundings, Proxy(point_tool({1e-3, 1e-3, 1e-3}), at({3e-3, 2e-3, 9e-3})), settings,
                0.5);
    block.link(probe);
    for (int tick = 0; tick < 400; ++tick) // twenty times what a new stiffness takes to blend in
      probe.tick(at({3.1e-3, 2.2e-3, 7.5e-3}));
    const double expected = rule == ForceRule::reaction ? of_block : of_block * 400 / (of_block + 400);
    EXPECT_NEAR(probe.state().force.force[2], expected * 0.5e-3, 2e-5 * expected * 0.5e-3); // skin and solver
    EXPECT_NEAR(probe.state().stiffness, of_block, 2e-5 * of_block);
    // The tool is shown where the block has come to: coupling and block share the depth.
    const double given_way = rule == ForceRule::reaction ? 0.5e-3 : 0.5e-3 * 400 / (of_block + 400);
    EXPECT_NEAR(probe.state().proxy[2], 8e-3 - given_way, 1e-8);
    EXPECT_NEAR(probe.state().depth, given_way, 1e-8);
    EXPECT_EQ(probe.n_sites(), 1);
  }
}

// Contract: nothing that hands or bodies do gives energy: a handle thrown at a block again and again, whose
// stiffness is first estimated 8 times too high and then becomes known.
TEST(ProbeContract, AHandleThrownAtABlockGetsNoEnergy) {
  Block block;
  ProbeSettings settings;
  settings.coupling.stiffness = 380;
  const double damping = 0.2;
  SimulatedDevice device(RecordedMotion({{0, at({3e-3, 2e-3, 9e-3})}}), {.mass = 0.05, .damping = damping},
                         settings.period);
  device.set_velocity({0.01, 0.005, -0.15});
  Probe probe(block.surroundings, Proxy(point_tool({1e-3, 1e-3, 1e-3}), at({3e-3, 2e-3, 9e-3})), settings,
              damping);
  block.link(probe);
  const double begin = device.kinetic_energy();
  bool has_touched = false;
  for (int tick = 0; tick < 1500; ++tick) {
    device.write(probe.tick(device.read()).force);
    has_touched = has_touched || probe.state().is_touching;
    ASSERT_LE(device.kinetic_energy(), begin);
  }
  EXPECT_TRUE(has_touched);
  EXPECT_GE(probe.passivity().least_energy(), -1e-6 * begin);
}

TEST(ProbeContract, TheSameHandFeelsTheSameBits) {
  Block block;
  const auto run = [&] {
    Probe probe(block.surroundings, Proxy(point_tool({1e-3, 1e-3, 1e-3}), at({3e-3, 2e-3, 9e-3})), {}, 0.5);
    block.newest = block.solver->estimate();
    block.link(probe);
    std::vector<Eigen::Vector3d> forces;
    for (int tick = 0; tick < 300; ++tick)
      forces.push_back(probe.tick(at({3e-3 + 1e-5 * tick, 2e-3, 8.2e-3 - 1e-5 * tick})).force.force);
    return forces;
  };
  EXPECT_EQ(run(), run());
}

TEST(ProbeContract, WhatIsNotPassiveOrNotFiniteIsRefused) {
  const Room room;
  ProbeSettings settings;
  settings.coupling.stiffness = 1001; // the bound of b = 0.5 at 1 kHz is 1000
  EXPECT_THROW(Probe(room.surroundings, room.point({5e-3, 5e-3, 15e-3}), settings, 0.5),
               std::invalid_argument);
  settings.coupling.stiffness = 900;
  settings.largest_force = 0.5;
  Probe probe(room.surroundings, room.point({5e-3, 5e-3, 15e-3}), settings, 0.5);
  probe.tick(at({5e-3, 5e-3, 5e-3}));
  EXPECT_NEAR(probe.state().force.force.norm(), 0.5, 1e-12); // 4.5 N are too many for the device
  const Eigen::Vector3d before = probe.state().proxy;
  probe.tick(at({std::nan(""), 0, 0}));
  EXPECT_EQ(probe.state().proxy, before);
  EXPECT_TRUE(probe.state().force.force.allFinite());
}

TEST(ProbeContract, ATurnedToolThatIsBlockedPushesBack) {
  const Room room;
  ProbeSettings settings;
  settings.coupling.turn_stiffness = 2e-3;
  const RigidShape bar({9, 1, 1}, {1e-3, 1e-3, 1e-3}, std::vector<std::uint8_t>(9, 1));
  Probe probe(room.surroundings, Proxy(bar, at({8.5e-3, 8.5e-3, 11.5e-3})), settings, 0.5);
  Pose hand = at({8.5e-3, 8.5e-3, 11.5e-3});
  hand.rotation =
      Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitY()).toRotationMatrix(); // its +x end down into the floor
  probe.tick(hand);
  EXPECT_TRUE(probe.proxy().is_turn_blocked());
  EXPECT_EQ(room.surroundings->n_inside(bar, probe.proxy().pose()), 0);
  // Analytic: the bar's lower side meets the middle of the floor's cell that is 4 cells out and 2 below the
  // hand, wherever it gave way to; about the hand itself it would turn until 4 sin + 1 / 2 = 2 cos.
  const Pose& pose = probe.proxy().pose();
  const double turned = Eigen::AngleAxisd(pose.rotation).angle();
  EXPECT_NEAR((pose.rotation.transpose() * (Eigen::Vector3d(12.5e-3, 8.5e-3, 9.5e-3) - pose.position))[2], 0,
              1e-9);
  EXPECT_GT(turned, std::atan(0.5) - std::asin(0.5 / std::sqrt(20.0)) - 1e-6);
  EXPECT_LT(turned, 0.6);
  EXPECT_NEAR(probe.state().force.torque[1], -2e-3 * (0.6 - turned), 1e-8);
}

/// An empty world of a few cells, a wall at z = 0.
struct Walls {
  Walls() : world({20, 20, 20}, {1e-3, 1e-3, 1e-3}) {
    surroundings = std::make_shared<Surroundings>(&world.map(), world.cell_size());
  }
  Probe probe() const {
    return {surroundings, Proxy(point_tool(world.cell_size()), at({5e-3, 5e-3, 5e-3})), {}, 0.5};
  }
  RigidWorld world;
  std::shared_ptr<const Surroundings> surroundings;
};

RecordedMotion down_and_up() {
  return RecordedMotion(
      {{0, at({5e-3, 5e-3, 5e-3})}, {0.2, at({6e-3, 5e-3, -2e-3})}, {0.4, at({5e-3, 7e-3, 5e-3})}});
}

// Oracle: the same ticks without a loop.
TEST(ServoLoopConsistent, ForcesAreThoseOfTicksByHand) {
  const Walls walls;
  Probe probe = walls.probe(), by_hand = walls.probe();
  SimulatedDevice device(down_and_up(), {.damping = 0.5}, 1e-3), same(down_and_up(), {.damping = 0.5}, 1e-3);
  ServoLoop loop(device, probe, {.ticks = 400, .in_real_time = false});
  const ServoReport& report = loop.wait();
  ASSERT_EQ(report.samples.size(), 400u);
  double largest = 0;
  for (const ServoSample& sample : report.samples) {
    const ProbeState& state = by_hand.tick(same.read());
    same.write(state.force);
    ASSERT_EQ(sample.state.force.force, state.force.force);
    largest = std::max(largest, state.force.force.norm());
  }
  EXPECT_NEAR(largest, 300 * 2e-3, 1e-6); // analytic: 2 mm into the wall
  EXPECT_EQ(report.latency.n(), 400);
  EXPECT_EQ(report.work.n(), 400);
  EXPECT_EQ(report.missed, 0);
}

/// A device that takes its time.
class SlowDevice : public ProbeDevice {
public:
  explicit SlowDevice(std::chrono::microseconds pause) : pause_(pause) {}
  Pose read() override {
    std::this_thread::sleep_for(pause_);
    return at({5e-3, 5e-3, 5e-3});
  }
  void write(const ProbeForce&) override { ++written; }
  double damping() const override { return 0.5; }

  int written = 0;

private:
  std::chrono::microseconds pause_;
};

TEST(ServoLoopContract, MissedDeadlinesAreCountedAndNeverCaughtUp) {
  const Walls walls;
  Probe probe = walls.probe();
  SlowDevice device(std::chrono::microseconds(3500)); // three and a half periods
  const auto begin = std::chrono::steady_clock::now();
  ServoLoop loop(device, probe, {.ticks = 30});
  const ServoReport& report = loop.wait();
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  EXPECT_EQ(report.ticks, 30);
  EXPECT_EQ(device.written, 30);
  EXPECT_GE(report.missed, 3 * 30); // at least three periods went by in each
  // Every period is a tick or missed; the last one's may be counted after the clock was read.
  EXPECT_NEAR(double(report.ticks + report.missed), 1e3 * seconds.count(), 0.02 * 1e3 * seconds.count() + 5);
  EXPECT_GE(report.latency.quantile(0), 3'500'000);
  EXPECT_GE(report.latency.largest(), report.work.largest());
}

TEST(ServoLoopContract, ItStopsWhenItIsTold) {
  const Walls walls;
  Probe probe = walls.probe();
  SlowDevice device(std::chrono::microseconds(100));
  ServoLoop loop(device, probe, {.ticks = 1'000'000});
  while (!loop.has_ended()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    loop.stop();
  }
  const ServoReport& report = loop.wait();
  EXPECT_GT(report.ticks, 0);
  EXPECT_LT(report.ticks, 1'000'000);
  EXPECT_EQ(report.samples.size(), std::size_t(report.ticks));
}

TEST(ServoLoopContract, PhysicsBesideDoesNotHoldUpTheLoop) {
  Scene scene = test::carved_body({12, 12, 12}, {1e-3, 1e-3, 1e-3});
  const std::shared_ptr<const BodySurface> surface =
      std::make_shared<BodySurface>(scene, Displacement(), Pose());
  const ContactSolver solver(scene, surface, 1e-3);
  ContactPhysics physics(solver, 1);
  const auto body = std::make_shared<Surroundings>(nullptr, Vec3{1e-3, 1e-3, 1e-3}, std::vector{surface});
  Probe probe(body, Proxy(point_tool({1e-3, 1e-3, 1e-3}), at({3e-3, 8e-3, 13e-3})), {}, 0.5);
  probe.link(0, physics, solver.depends_on_depth());
  SimulatedDevice device(
      RecordedMotion(
          {{0, at({3e-3, 8e-3, 13e-3})}, {0.1, at({3e-3, 8e-3, 11e-3})}, {0.5, at({11e-3, 9e-3, 11e-3})}}),
      {.damping = 0.5}, 1e-3);
  ServoLoop loop(device, probe, {.ticks = 600});
  const ServoReport& report = loop.wait();
  EXPECT_EQ(report.ticks, 600);
  EXPECT_GT(probe.n_sites(), 3);
  EXPECT_GT(report.samples.back().state.force.force[2], 0);
  // Contract: the arithmetic is not waiting: half of all ticks take a small part of a solve's time, or of the
  // period.
  EXPECT_LT(report.work.quantile(0.5), 500'000);
}

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
