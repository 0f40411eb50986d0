#include "bench/subjects.hpp"
#include "maille/deform/probe/touch.hpp"
#include "maille/deform/world/trajectory_drives.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace maille::lab {

namespace {

using deform::Drive;
using deform::Pose;
using deform::World;
using Eigen::Vector3d;

constexpr double mm = 1e-3, pitch = 10 * mm;
/// Where the nut stands on the thread's upper end, and how far it is turned there so that ridges stand
/// between ridges (scene/scenes/world/bolt_assembled.toml).
constexpr double start_height = 47, turned_at_start = std::numbers::pi;

std::string bolt(bool has_nut) {
  const std::string thread =
      "thread = { radius = \"7 mm\", depth = \"2 mm\", pitch = \"10 mm\", play = \"1 mm\" }\n";
  std::string text = "[world]\ncells = [40, 40, 80]\nspacing = \"1 mm\"\n[[object]]\nname = \"bolt\"\nkind = "
                     "\"fixed\"\nshape = \"bolt\"\ncells = [28, 28, 44]\nhead = \"8 mm\"\nposition = "
                     "[\"6 mm\", \"6 mm\", \"2 mm\"]\n" +
                     thread;
  if (has_nut)
    text += "[[object]]\nname = \"nut\"\nkind = \"rigid\"\nshape = \"nut\"\ncells = [24, 24, 10]\nposition = "
            "[\"8 mm\", \"8 mm\", \"62 mm\"]\n" +
            thread;
  return text;
}

Vector3d middle_of(const World& world, const Pose& pose) {
  return pose.position + pose.rotation * deform::middle_of(world.scene().objects[1].scene.specimen);
}

/// The nut on the upper end of the thread.
World world_with_nut() {
  World world(parse_world_scene(bolt(true)));
  Drive drive;
  drive.object = 1;
  drive.motion.by = {0, 0, (start_height - 62) * mm};
  world.advance({&drive, 1});
  drive.motion.by.setZero();
  drive.motion.axis = Vector3d::UnitZ();
  drive.motion.about = middle_of(world, world.pose(1));
  for (int quarter = 0; quarter < 2; ++quarter) {
    drive.motion.angle = 0.5 * turned_at_start;
    world.advance({&drive, 1});
  }
  return world;
}

/// Pose of the nut's lattice after `n_turns` turns by a steady hand, with a relative error `off` of the
/// pitch.
Pose screwed(const World& world, const Pose& start, double n_turns, double off) {
  deform::RigidMotion motion;
  motion.axis = Vector3d::UnitZ();
  motion.about = middle_of(world, start);
  motion.by = {0, 0, -n_turns * pitch * (1 + off)};
  Pose pose = start;
  for (double left = n_turns; left > 0; left -= 0.25) { // a motion turns by half a circle at most
    deform::RigidMotion part = motion;
    part.by.setZero();
    part.angle = -2 * std::numbers::pi * std::min(left, 0.25);
    pose = part.moved(pose, 1);
  }
  pose.position += motion.by;
  return pose;
}

} // namespace

void report_nut(bool quick, BenchReport& report) {
  const auto seconds_since = [](auto start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  World world = world_with_nut();
  const deform::RigidWorld bolt_alone = [] {
    const World alone(parse_world_scene(bolt(false)));
    deform::RigidWorld rigid({40, 40, 80}, {mm, mm, mm});
    rigid.add(alone.shape(0), alone.pose(0));
    return rigid;
  }();
  const deform::Surroundings around(&bolt_alone.map(), bolt_alone.cell_size());
  const Pose begin = world.pose(1);
  deform::Proxy proxy(world.shape(1), {begin.rotation, middle_of(world, begin)});
  std::vector<double> ticks;
  for (int tick = 1; tick <= (quick ? 50 : 500); ++tick) { // a turn a second, a pitch 10 % off
    const Pose hand = screwed(world, begin, 1e-3 * tick, 0.1);
    const auto start = std::chrono::steady_clock::now();
    proxy.follow(around, {hand.rotation, middle_of(world, hand)});
    ticks.push_back(seconds_since(start));
  }
  std::ranges::sort(ticks);
  const double median = ticks[ticks.size() / 2], late = ticks[ticks.size() * 99 / 100];
  report.add({{"what", "a tick of the nut's proxy on its thread"},
              {"voxels", world.shape(1).n_voxels()},
              {"microseconds", 1e6 * median},
              {"ns_per_voxel", 1e9 * median / world.shape(1).n_voxels()},
              {"note", fmt::format("median of {} ticks; 99 % within {:.3g} us", ticks.size(), 1e6 * late)}});
  report.checks.push_back({"nut_tick_ms", 1e3 * median, "0.3", "at 1 kHz a tick has a millisecond"});
}

} // namespace maille::lab
