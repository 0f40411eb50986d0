#include "bench/world/world.hpp"
#include "maille/deform/world/world.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>
#include <string>

namespace maille::lab {

namespace {

using deform::World;

constexpr double mm = 1e-3;

/// Discs of voxels in a row, the first of which runs into the others.
World cradle(int balls) {
  std::string text = "[world]\ncells = [140, 20]\nspacing = \"1 mm\"\ndynamics = { restitution = 1 }\n";
  for (int ball = 0; ball < balls; ++ball)
    text +=
        fmt::format("[[object]]\nname = \"ball{}\"\nkind = \"rigid\"\nshape = \"ellipsoid\"\ncells = [8, 8]\n"
                    "position = [\"{:.4f} mm\", \"6 mm\"]\n{}\n",
                    ball, ball == 0 ? 5.0 : 20 + 8.0001 * ball, ball == 0 ? "velocity = [0.5, 0]" : "");
  return World(parse_world_scene(text));
}

/// Boxes that fly about at random, meeting one another, until the first reaches the border.
World crowd(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::string text = "[world]\ncells = [120, 120]\nspacing = \"1 mm\"\ndynamics = { restitution = 1 }\n";
  for (int i = 0; i < 9; ++i)
    text += fmt::format(
        "[[object]]\nname = \"box{}\"\nkind = \"rigid\"\nshape = \"box\"\ncells = [{}, {}]\nposition = "
        "[\"{} mm\", \"{} mm\"]\nvelocity = [{:.3f}, {:.3f}]\n",
        i, 5 + i % 3, 4 + i % 4, 40 + 13 * (i % 3), 40 + 13 * (i / 3), 0.3 * unit(random),
        0.3 * unit(random));
  return World(parse_world_scene(text));
}

/// A soft box that two rigid discs run into, one beside its middle.
World soft_crowd() {
  const auto disc = [](const char* name, const char* position, const char* velocity) {
    return fmt::format("[[object]]\nname = \"{}\"\nkind = \"rigid\"\nshape = \"ellipsoid\"\ncells = [8, 8]\n"
                       "position = [{}]\nvelocity = [{}]\n",
                       name, position, velocity);
  };
  return World(parse_world_scene(
      "[world]\ncells = [120, 120]\nspacing = \"1 mm\"\ndynamics = { }\n[[object]]\nname = \"soft\"\nkind "
      "= \"deformable\"\nshape = \"box\"\ncells = [16, 12]\nposition = [\"52 mm\", \"54 mm\"]\nmaterial = "
      "{ youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }\n" +
      disc("left", "\"40 mm\", \"60 mm\"", "0.3, 0") + disc("lower", "\"54 mm\", \"40 mm\"", "0, 0.2")));
}

struct Kept {
  double momentum = 0, energy_gain = 0;
  std::int64_t frames = 0, unsettled = 0, penetrations = 0;
};

void watch(World& world, int frames, double seconds, Kept& worst) {
  const auto momentum = [&] {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int object = 0; object < world.n_objects(); ++object)
      sum += world.motion(object).mass * world.motion(object).velocity;
    return sum;
  };
  double scale = 0;
  for (int object = 0; object < world.n_objects(); ++object)
    scale += world.motion(object).mass * world.motion(object).velocity.norm();
  const Eigen::Vector3d before = momentum();
  const double energy = world.energy();
  deform::FrameBudget budget;
  budget.frame_seconds = seconds;
  for (int frame = 0; frame < frames; ++frame) {
    const auto result = world.advance({}, budget);
    if (std::ranges::any_of(result.contacts, [](const auto& contact) { return contact.other < 0; }))
      break; // the border takes momentum
    ++worst.frames;
    worst.unsettled += result.status != Status::done;
    worst.penetrations += world.n_penetrations();
    worst.momentum = std::max(worst.momentum, (momentum() - before).norm() / scale);
    worst.energy_gain = std::max(worst.energy_gain, world.energy() / energy - 1);
  }
}

} // namespace

void report_dynamics(bool quick, BenchReport& report) {
  const auto start = std::chrono::steady_clock::now();
  Kept worst;
  World row = cradle(5);
  watch(row, 20, 5 * mm, worst);
  for (unsigned seed = 0; seed < (quick ? 2u : 20u); ++seed) {
    World world = crowd(seed);
    watch(world, 40, 5 * mm, worst);
  }
  World soft = soft_crowd();
  watch(soft, quick ? 10 : 30, 5 * mm, worst);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  add_row_per(report, "a frame of 5 ms of discs and boxes that meet", worst.frames, seconds,
              fmt::format("Newton's cradle, crowds at random, a soft box between discs; {} frames, {} not to "
                          "their end, {} penetrations",
                          worst.frames, worst.unsettled, worst.penetrations));
  report.checks.push_back({"momentum_error", worst.momentum, "1e-14: rounding",
                           "of all objects together, over the sum of their sizes at first"});
  report.checks.push_back(
      {"energy_gain", worst.energy_gain, "1e-9", "restitution 1, or soft: energy over that at first"});
}

} // namespace maille::lab
