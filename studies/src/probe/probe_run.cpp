#include "probe/probe_run.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <list>
#include <stdexcept>
#include <thread>

namespace maille::studies {

namespace {

using deform::ContactPhysics;
using deform::ContactSite;
using deform::ContactStiffness;
using deform::Probe;
using deform::ProbedWorld;

constexpr std::int64_t most_looks = 1000;

/// Solves within the tick, so that a run is repeatable to the bit.
struct AtOnce {
  const deform::ContactSolver* solver;
  ContactStiffness newest;
  std::int64_t answers = 0;
  double slowest = 0;
};

/// All data of bodies that must outlive a probe.
class Physics {
public:
  Physics(const ProbedWorld& world, const ProbeRunSettings& settings) {
    for (int body = 0; body < world.n_bodies(); ++body)
      if (settings.in_real_time)
        beside_.emplace_back(world.solver(body), settings.threads);
      else
        at_once_.push_back({&world.solver(body), world.solver(body).estimate()});
  }

  void link(const ProbedWorld& world, Probe& probe) {
    int body = 0;
    for (ContactPhysics& physics : beside_) {
      probe.link(body, physics, world.solver(body).depends_on_depth());
      ++body;
    }
    for (AtOnce& physics : at_once_) {
      const auto ask = [&physics](const ContactSite& site) {
        physics.newest = physics.solver->solve(site);
        physics.newest.answers = ++physics.answers;
        physics.slowest = std::max(physics.slowest, physics.newest.seconds);
      };
      probe.link(body, {ask, [&physics]() -> const ContactStiffness& { return physics.newest; },
                        physics.solver->depends_on_depth()});
      ++body;
    }
  }

  /// @pre the loop has ended
  void count(ProbeRun& run) {
    for (ContactPhysics& physics : beside_) {
      run.answers += physics.newest().answers;
      run.slowest_answer = std::max(run.slowest_answer, physics.newest().slowest);
    }
    for (const AtOnce& physics : at_once_) {
      run.answers += physics.answers;
      run.slowest_answer = std::max(run.slowest_answer, physics.slowest);
    }
  }

private:
  std::list<ContactPhysics> beside_;
  std::list<AtOnce> at_once_;
};

/// Repeats the ticks of the loop without a clock to check them: proxies depend only on poses.
void look_again(const ProbedWorld& world, const deform::RecordedMotion& motion,
                const ProbeRunSettings& settings, const Control& control, ProbeRun& run) {
  deform::Proxy proxy(world.tool(), motion.at(0));
  const std::int64_t ticks_a_look = std::max<std::int64_t>(run.servo.ticks / most_looks, 1);
  std::int64_t tick = 0;
  for (const deform::ServoSample& sample : run.servo.samples) {
    if (control.should_stop())
      return;
    deform::Pose hand = motion.at(static_cast<double>(tick) * settings.probe.period);
    hand.position = sample.state.device;
    proxy.follow(*world.surroundings(), hand);
    if (tick++ % ticks_a_look == 0) {
      run.inside += world.surroundings()->n_inside(proxy.tool(), proxy.pose()) > 0;
      ++run.looks;
      if (control.progress)
        control.progress(static_cast<double>(tick) / static_cast<double>(run.servo.ticks),
                         "looking whether it was in matter");
    }
  }
}

} // namespace

std::optional<std::int64_t> ticks_of(const deform::RecordedMotion& motion, double period) {
  const double ticks = std::round(motion.duration() / period) + 1;
  if (!(ticks <= static_cast<double>(most_probe_ticks)))
    return std::nullopt;
  return std::max<std::int64_t>(static_cast<std::int64_t>(ticks), 1);
}

ProbeRun run_probe(const ProbedWorld& world, const deform::RecordedMotion& motion,
                   const ProbeRunSettings& settings, const Control& control) {
  const deform::Pose begin = motion.at(0);
  deform::Proxy proxy(world.tool(), begin);
  if (world.surroundings()->n_inside(world.tool(), proxy.pose()) > 0)
    throw std::invalid_argument("the motion begins in matter, or outside the world");
  Physics physics(world, settings);
  Probe probe(world.surroundings(), proxy, settings.probe, settings.hand.damping);
  physics.link(world, probe);
  deform::SimulatedDevice device(motion, settings.hand, settings.probe.period);
  ProbeRun run;
  run.passive_stiffness = deform::largest_passive_stiffness(
      settings.hand.damping, settings.probe.coupling.damping, settings.probe.period);
  deform::ServoSettings servo;
  const auto ticks = ticks_of(motion, settings.probe.period);
  if (!ticks)
    throw std::invalid_argument("the motion takes more ticks than are kept");
  servo.ticks = *ticks;
  servo.in_real_time = settings.in_real_time;
  {
    deform::ServoLoop loop(device, probe, servo);
    while (!loop.has_ended()) {
      if (control.should_stop())
        loop.stop();
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    run.servo = loop.wait();
  }
  run.has_clock = settings.in_real_time;
  run.was_interrupted = run.servo.ticks < *ticks;
  physics.count(run);
  run.least_energy = probe.passivity().least_energy();
  run.taken_back = probe.passivity().taken_back();
  run.sites = probe.n_sites();
  look_again(world, motion, settings, control, run);
  return run;
}

} // namespace maille::studies
