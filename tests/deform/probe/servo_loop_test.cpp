#include "maille/deform/probe/servo_loop.hpp"

#include "deform/probe/probe_scenes.hpp"
#include "maille/deform/probe/device.hpp"

#include <gtest/gtest.h>

#include <chrono>

namespace maille::deform {
namespace {

Pose at(const Eigen::Vector3d& position) {
  return Pose{.position = position};
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
TEST(ServoLoopOracle, ForcesAreThoseOfTicksByHand) {
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
  EXPECT_NEAR(static_cast<double>(report.ticks + report.missed), 1e3 * seconds.count(),
              0.02 * 1e3 * seconds.count() + 5);
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
  EXPECT_EQ(report.samples.size(), static_cast<std::size_t>(report.ticks));
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

} // namespace
} // namespace maille::deform
