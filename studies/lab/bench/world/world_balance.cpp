#include "bench/world/world.hpp"
#include "maille/deform/world/world.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace maille::lab {

namespace {

using deform::Drive;
using deform::FrameResult;
using deform::World;
using deform::WorldContact;
using Eigen::Vector3d;

constexpr double mm = 1e-3;
constexpr int disc_cells = 14;

std::string object(const std::string& name, const std::string& kind, const std::string& shape,
                   const std::string& cells, const std::string& position, const std::string& more = "") {
  return fmt::format(
      "[[object]]\nname = \"{}\"\nkind = \"{}\"\nshape = \"{}\"\ncells = [{}]\nposition = [{}]\n{}\n", name,
      kind, shape, cells, position, more);
}

const char* const soft = "material = { youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }";

/// Five free soft discs between a plunger and the walls of a box, the same above and below its middle.
World five_discs() {
  std::string text = "[world]\ncells = [60, 44]\nspacing = \"1 mm\"\ncontact = \"surfaces\"\n" +
                     object("plunger", "rigid", "box", "3, 42", "\"1 mm\", \"1 mm\"");
  const char* const places[] = {"\"6.5 mm\", \"5.5 mm\"", "\"6.5 mm\", \"24.5 mm\"", "\"24.5 mm\", \"15 mm\"",
                                "\"40.5 mm\", \"5.5 mm\"", "\"40.5 mm\", \"24.5 mm\""};
  for (int i = 0; i < 5; ++i)
    text += object(fmt::format("disc{}", i), "deformable", "ellipsoid", "14, 14", places[i], soft);
  return World(parse_world_scene(text));
}

Vector3d middle_of_disc(const World& world, int disc) {
  return world.position(disc, disc_cells / 2 * (disc_cells + 1) + disc_cells / 2);
}

struct Worst {
  double action_reaction = 0, equilibrium = 0, mirror = 0, seconds = 0;
  std::int64_t frames = 0, pressed = 0, rounds = 0, unsettled = 0, penetrations = 0;
};

/// Checks one frame: forces of each pair, forces and moments on each disc, symmetry of places.
void look(const World& world, const FrameResult& result, Worst& worst) {
  double largest = 0;
  for (const WorldContact& contact : result.contacts)
    largest = std::max(largest, contact.force.norm());
  worst.seconds += result.seconds;
  worst.rounds += result.rounds;
  ++worst.frames;
  worst.unsettled += result.status == Status::budget_reached;
  worst.penetrations += world.n_penetrations();
  constexpr double least = 1e-6; // [N]: nothing but what a free disc is pushed along with
  worst.pressed += largest > least;
  if (result.status != Status::budget_reached && largest > least)
    for (int one = 0; one < world.n_objects(); ++one) {
      Vector3d force = Vector3d::Zero(), moment = force;
      for (const WorldContact& contact : result.contacts)
        if (contact.object == one) {
          force += contact.force;
          if (world.kind(one) == ObjectKind::deformable)
            moment += (*contact.at - middle_of_disc(world, one)).cross(contact.force);
        }
      if (world.kind(one) == ObjectKind::deformable)
        worst.equilibrium = std::max(
            {worst.equilibrium, force.norm() / largest, moment.norm() / (largest * 0.5 * disc_cells * mm)});
      for (int other = 0; other < one; ++other) {
        Vector3d sum = Vector3d::Zero();
        for (const WorldContact& contact : result.contacts)
          if ((contact.object == one && contact.other == other) ||
              (contact.object == other && contact.other == one))
            sum += contact.force;
        worst.action_reaction = std::max(worst.action_reaction, sum.norm() / largest);
      }
    }
  for (const auto& [upper, lower] : {std::pair(2, 1), std::pair(5, 4)}) {
    const Vector3d a = middle_of_disc(world, upper), b = middle_of_disc(world, lower);
    worst.mirror = std::max(worst.mirror, std::hypot(a[0] - b[0], a[1] + b[1] - 44 * mm) / (disc_cells * mm));
  }
}

/// Force of a stamp on a block, everything shifted by so much [of a cell].
double stamp_force(double shift, bool quick) {
  const int edge = quick ? 6 : 10;
  const auto at = [&](double x) { return fmt::format("\"{:.6f} mm\"", x + shift); };
  const std::string text =
      "[world]\ncells = [20, 20, 24]\nspacing = \"1 mm\"\ncontact = \"surfaces\"\n" +
      object("block", "deformable", "box", fmt::format("{0}, {0}, 6", edge),
             at(3) + ", " + at(3) + ", " + at(2), std::string(soft) + "\nhold = [{ where = \"z-\" }]") +
      object("stamp", "rigid", "box", "3, 3, 3", at(3 + edge / 2) + ", " + at(3 + edge / 2) + ", " + at(9.2));
  World world(parse_world_scene(text));
  Drive drive;
  drive.object = 1;
  drive.motion.by = {0, 0, -2.3 * mm};
  return world.advance({&drive, 1}).drives[0].force[2];
}

} // namespace

void report_balance(bool quick, BenchReport& report) {
  World world = five_discs();
  Drive drive;
  drive.object = 0;
  drive.motion.by = {0.5 * mm, 0, 0};
  Worst worst;
  for (int frame = 0; frame < (quick ? 60 : 62); ++frame)
    look(world, world.advance({&drive, 1}), worst);
  add_row_per(
      report, "a frame of five free soft discs that a plunger presses by half a cell", worst.frames,
      worst.seconds,
      fmt::format("contact of surfaces; {} rounds in {} frames, {} pressed, {} not settled, {} penetrations",
                  worst.rounds, worst.frames, worst.pressed, worst.unsettled, worst.penetrations));
  if (worst.pressed == 0) // nothing was looked at
    worst.action_reaction = worst.equilibrium = 1;
  report.checks.push_back({"action_reaction_worst", worst.action_reaction, "1e-12: one number",
                           "of each pair of objects, over the largest force of a contact in that frame"});
  report.checks.push_back({"equilibrium_worst", worst.equilibrium, "1e-9",
                           "force and moment over half a disc on each free disc, over the largest force"});
  report.checks.push_back(
      {"mirror_symmetry", worst.mirror, "1e-12", "middles of discs that mirror one another, over a disc"});
  const double at_first = stamp_force(0, quick);
  double error = 0;
  for (const double shift : {0.25, 0.5})
    error = std::max(error, std::abs(stamp_force(shift, quick) / at_first - 1));
  report.checks.push_back({"shift_error", error, "1e-9: nothing depends on the world's cells",
                           "a stamp on a block, all shifted by a quarter and half of a cell"});
}

} // namespace maille::lab
