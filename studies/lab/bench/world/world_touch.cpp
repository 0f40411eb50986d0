#include "bench/world/world.hpp"
#include "maille/deform/world/world.hpp"
#include "probe/probe_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace maille::lab {

namespace {

using deform::Drive;
using deform::Pose;
using deform::ProbedWorld;
using deform::RecordedMotion;
using deform::World;
using Eigen::Vector3d;

constexpr double mm = 1e-3;

ProbeRun felt(const ProbedWorld& world, std::vector<RecordedMotion::Sample> samples, bool in_real_time) {
  ProbeRunSettings settings;
  settings.hand.damping = 0.5;
  settings.in_real_time = in_real_time;
  return run_probe(world, RecordedMotion(std::move(samples)), settings);
}

// A stroke over bone: a fingertip goes round a head from CT, six millimetres and more under its surface.

std::string skull() {
  return R"([world]
cells   = [64, 64, 93]
spacing = ["3.2 mm", "3.2 mm", "1.5 mm"]
[[object]]
name      = "skull"
kind      = "fixed"
shape     = "image"
image     = "$MAILLE_DATA/head_ct/headsq.mha"
threshold = 1150
turn      = { angle = "180 deg", axis = [1, 0, 0] }
position  = [0, "204.8 mm", "139.5 mm"]
)";
}

void stroke_a_skull(BenchReport& report) {
  if (std::getenv("MAILLE_DATA") == nullptr) {
    report.notes.emplace_back("force_step_worst omitted: MAILLE_DATA names no images.");
    return;
  }
  const ProbedWorld world(parse_world_scene(skull()), -1, 0);
  // In from outside, then along an arc of 60 mm radius at 60 mm/s.
  std::vector<RecordedMotion::Sample> samples{{0, Pose{.position = Vector3d(100 * mm, 4 * mm, 100 * mm)}},
                                              {0.6, Pose{.position = Vector3d(100 * mm, 40 * mm, 100 * mm)}}};
  for (int i = 1; i <= 60; ++i) {
    const double angle = 0.5 * std::numbers::pi * i / 60;
    samples.push_back(
        {0.6 + 0.025 * i, Pose{.position = Vector3d(100 * mm + 60 * mm * std::sin(angle),
                                                    100 * mm - 60 * mm * std::cos(angle), 100 * mm)}});
  }
  const ProbeRun run = felt(world, std::move(samples), false);
  double largest = 0, worst = 0, newtons = 0;
  std::int64_t touching = 0;
  for (const auto& sample : run.servo.samples)
    largest = std::max(largest, sample.state.force.force.norm());
  for (std::size_t i = 1; i < run.servo.samples.size(); ++i) {
    const auto &before = run.servo.samples[i - 1].state, &now = run.servo.samples[i].state;
    const double force = std::max(before.force.force.norm(), now.force.force.norm());
    if (!before.is_touching || !now.is_touching || force < 0.05 * largest)
      continue;
    ++touching;
    const double step = (now.force.force - before.force.force).norm();
    newtons = std::max(newtons, step);
    worst = std::max(worst, step / force);
  }
  add_row_per(report, "a tick of a fingertip that strokes a skull", std::max<std::int64_t>(touching, 1),
              1e-9 * run.servo.work.mean() * static_cast<double>(touching),
              fmt::format("{} ticks in contact of {}; forces to {:.3g} N, a step of {:.3g} N at most",
                          touching, run.servo.ticks, largest, newtons));
  report.checks.push_back({"force_step_worst", touching > 0 ? worst : 1, "0.02: 60 um a tick, of a few mm",
                           "the force's change from a tick to the next over the larger of both"});
}

// A probe that comes down on a muscle and stays.

std::string muscle() {
  return R"([world]
cells   = [50, 24, 36]
spacing = "1 mm"
[[object]]
name     = "muscle"
kind     = "deformable"
shape    = "muscle"
cells    = [36, 13, 13]
material = { youngs_modulus = "20 kPa", poisson_ratio = 0.4 }
tendon   = { material = { youngs_modulus = "500 kPa", poisson_ratio = 0.4 }, fraction = 0.15 }
hold     = [{ where = "x-" }, { where = "x+" }]
position = ["6.5 mm", "5.5 mm", "5.5 mm"]
)";
}

void touch_a_muscle(BenchReport& report) {
  const ProbedWorld world(parse_world_scene(muscle()), -1, 3 * mm);
  const auto at = [](double z) { return Pose{.position = Vector3d(23.5 * mm, 12 * mm, z * mm)}; };
  const ProbeRun run = felt(world, {{0, at(26)}, {0.4, at(16)}, {1.4, at(16)}}, true);
  double largest = 0;
  for (const auto& sample : run.servo.samples)
    largest = std::max(largest, sample.state.force.force.norm());
  const double last = run.servo.samples.back().state.force.force.norm();
  add_row_per(
      report, "a tick of a probe that comes down on a muscle", run.servo.ticks,
      1e-9 * run.servo.work.mean() * static_cast<double>(run.servo.ticks),
      fmt::format("in real time; the force comes to {:.3g} N and ends at {:.3g} N; the slowest answer "
                  "took {:.3g} s",
                  largest, last, run.slowest_answer));
  report.checks.push_back({"first_touch_overshoot", last > 0 ? largest / last - 1 : 1, "0.01",
                           "the largest force over that at the same depth a second later, less 1"});
}

// The same stamp led by the same spring, in a played world and as a probe's tool.

std::string stamp_on_a_block(bool has_block) {
  std::string text = "[world]\ncells = [32, 32, 32]\nspacing = \"1 mm\"\ncontact = \"surfaces\"\n";
  if (has_block)
    text += "[[object]]\nname = \"block\"\nkind = \"deformable\"\nshape = \"box\"\ncells = [14, 14, 10]\n"
            "material = { youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }\nhold = [{ where = \"z-\" }]\n"
            "position = [\"9 mm\", \"9 mm\", \"2 mm\"]\n";
  return text + "[[object]]\nname = \"stamp\"\nkind = \"rigid\"\nshape = \"box\"\ncells = [4, 4, 4]\n"
                "position = [\"14 mm\", \"14 mm\", \"13 mm\"]\n";
}

void press_a_stamp(BenchReport& report) {
  const WorldScene scene = parse_world_scene(stamp_on_a_block(true));
  World played(scene);
  Drive drive;
  drive.object = 1;
  drive.motion.by = {0, 0, -3 * mm}; // a gap of 1 mm, then 2 mm
  drive.lead = Drive::Lead{played.pose(1), 300};
  const double of_play = played.advance({&drive, 1}).drives[0].force.norm();
  const ProbedWorld probed(scene, 1, 0);
  const Pose begin = *probed.start();
  Pose end = begin;
  end.position[2] -= 3 * mm;
  const ProbeRun run = felt(probed, {{0, begin}, {0.3, end}, {0.6, end}}, false);
  const double of_probe = run.servo.samples.back().state.force.force.norm();
  add_row_per(report, "a tick of a stamp on a block", run.servo.ticks,
              1e-9 * run.servo.work.mean() * static_cast<double>(run.servo.ticks),
              fmt::format("a spring of 300 N/m, 2 mm into a block: {:.4g} N played, {:.4g} N probed", of_play,
                          of_probe));
  report.checks.push_back({"play_probe_force_ratio", std::abs(of_probe / of_play - 1), "0.01: one law",
                           "what the ratio of both forces is off 1 by"});
}

} // namespace

void report_touch(BenchReport& report) {
  stroke_a_skull(report);
  touch_a_muscle(report);
  press_a_stamp(report);
}

} // namespace maille::lab
