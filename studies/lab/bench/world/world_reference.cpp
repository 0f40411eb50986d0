#include "bench/world/ball_on_layer.hpp"
#include "bench/world/world.hpp"
#include "maille/deform/world/world.hpp"
#include "maille/fem_ref/solve.hpp"
#include "maille/scene/answer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

namespace maille::lab {

namespace {

using deform::Drive;
using deform::FrameResult;
using deform::World;
using Eigen::Vector3d;

constexpr double mm = 1e-3, youngs_modulus = 10e3, poisson_ratio = 0.3;

/// A quarter of a block under a quarter of a smooth ball: planes of symmetry at x- and y-.
World ball_on_a_block(const Index3& cells, int radius) {
  const std::string block = fmt::format(
      "[[object]]\nname = \"block\"\nkind = \"deformable\"\nshape = \"box\"\ncells = [{}, {}, {}]\n"
      "material = {{ youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }}\n"
      "hold = [{{ where = \"z-\" }}, {{ where = \"x-\", axes = \"x\" }}, {{ where = \"y-\", axes = \"y\" "
      "}}]\n"
      "position = [\"{} mm\", \"{} mm\", \"1 mm\"]\n",
      cells[0], cells[1], cells[2], radius + 1, radius + 1);
  const std::string ball =
      fmt::format("[[object]]\nname = \"ball\"\nkind = \"rigid\"\nshape = \"ellipsoid\"\ncells = [{0}, {0}, "
                  "{0}]\nsurface = \"smooth\"\nposition = [\"1 mm\", \"1 mm\", \"{1} mm\"]\n",
                  2 * radius, cells[2] + 1.1);
  return World(parse_world_scene(
      fmt::format("[world]\ncells = [{0}, {0}, {1}]\nspacing = \"1 mm\"\ncontact = \"surfaces\"\n",
                  std::max(2 * radius + 2, cells[0] + radius + 2), cells[2] + 2 * radius + 4) +
      block + ball));
}

void press_a_ball(bool quick, BenchReport& report) {
  const int radius = quick ? 8 : 16;
  // Wide against its height: sideways it has no end then.
  const Index3 cells = quick ? Index3{12, 12, 8} : Index3{25, 25, 16};
  const double depth = 0.1 * radius * mm;
  World world = ball_on_a_block(cells, radius);
  Drive drive;
  drive.object = 1;
  drive.motion.by = {0, 0, -0.1 * mm - depth};
  const FrameResult result = world.advance({&drive, 1});
  double force = 0, moment = 0;
  std::int64_t n = 0;
  for (const auto& contact : result.contacts)
    if (contact.object == 1 && contact.other == 0) {
      const double along = contact.force[2];
      force += along;
      moment += along * (contact.at->head<2>() - Eigen::Vector2d::Constant((radius + 1) * mm)).squaredNorm();
      ++n;
    }
  LayerContact truth = ball_on_layer(radius * mm, depth, cells[2] * mm, youngs_modulus, poisson_ratio);
  truth.force /= 4; // a quarter of it
  const double of_hertz = youngs_modulus / (1 - poisson_ratio * poisson_ratio) / 3 * std::sqrt(radius * mm) *
                          std::pow(depth, 1.5),
               contact_radius = force > 0 ? std::sqrt(2.5 * moment / force) : 0;
  report.add(
      {{"what", fmt::format("a smooth ball of {} cells' radius on a block of {} cells", radius, cells[2])},
       {"voxels", n},
       {"microseconds", 1e6 * result.seconds},
       {"ns_per_voxel", 1e9 * result.seconds / static_cast<double>(std::max<std::int64_t>(n, 1))},
       {"note", fmt::format("a contact in place of a voxel; radius {:.4g} mm for {:.4g}, force {:.4g} mN for "
                            "{:.4g} of Hertz's ball on a layer, {:.4g} where it has no end; {} rounds, {}",
                            contact_radius / mm, truth.radius / mm, 1e3 * force, 1e3 * truth.force,
                            1e3 * of_hertz, result.rounds, std::string(to_string(result.status)))}});
  report.checks.push_back(
      {"hertz_error",
       std::max(std::abs(force / truth.force - 1), std::abs(contact_radius / truth.radius - 1)),
       "0.03: cells of a fifth of the contact's radius",
       "the larger error of force and radius of contact, pressed by a tenth of the radius into a block on "
       "rigid ground"});
}

/// A quarter of a block of 12 x 12 x 8 mm under a tool (planes of symmetry at x- and y-), in a world of a
/// quarter of its cells; quadratic elements get the nodes that touch where the world has put them.
/// @param from, to  of the tool along x and y [mm]; the block's middle is at 3.6
/// @param per_mm  cells of the block
double error_of_contact(double from, double to, int per_mm, BenchReport& report) {
  const double h = 1.0 / per_mm;
  const std::string text = fmt::format(
      "[world]\ncells = [{0}, {0}, {1}]\nspacing = \"{2:.17g} mm\"\n[[object]]\nname = \"block\"\nkind = "
      "\"deformable\"\nshape = \"box\"\ncells = [{3}, {3}, {4}]\nspacing = \"{5:.17g} mm\"\nmaterial = {{ "
      "youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }}\nhold = [{{ where = \"z-\" }}, {{ where = \"x-\", "
      "axes = \"x\" }}, {{ where = \"y-\", axes = \"y\" }}]\nposition = [\"3.6 mm\", \"3.6 mm\", \"2.1 "
      "mm\"]\n"
      "[[object]]\nname = \"tool\"\nkind = \"rigid\"\nshape = \"box\"\ncells = [{6}, {6}, 3]\n"
      "position = [\"{7} mm\", \"{7} mm\", \"10.75 mm\"]\n",
      40 * per_mm, 64 * per_mm, 0.25 * h, 6 * per_mm, 8 * per_mm, h,
      static_cast<int>(std::lround(4 * (to - from) * per_mm)), from);
  World world(parse_world_scene(text));
  Drive drive;
  drive.object = 1;
  drive.motion.by = {0, 0, -1.0 * mm}; // by a third of a millimetre: fine cells fold under the edge of one
  const FrameResult result = world.advance({&drive, 1});
  Scene scene = world.scene().objects[0].scene;
  for (const auto& contact : result.contacts)
    if (contact.object == 0)
      scene.prescribed.push_back({contact.voxel, 2, world.displacement(0)(2, contact.voxel), false});
  std::ranges::sort(scene.prescribed, {}, [](const Prescribed& p) { return std::pair(p.component, p.node); });
  fem_ref::Options options;
  options.degree = 2;
  const Answer answer = fem_ref::solve(scene, options).answer;
  const double error = is_converged(result.status) && !result.contacts.empty() && is_converged(answer.status)
                           ? compare(scene, world.displacement(0), answer.displacement).relative_l2
                           : 1;
  report.add(
      {{"what", fmt::format("a tool of {} mm on a block, {} cells a mm", to - from, per_mm)},
       {"voxels", static_cast<std::int64_t>(result.contacts.size())},
       {"microseconds", 1e6 * result.seconds},
       {"ns_per_voxel",
        1e9 * result.seconds / std::max<double>(1, static_cast<double>(result.contacts.size()))},
       {"note", fmt::format("a contact in place of a voxel; {:.3g} off quadratic elements with the same "
                            "nodes prescribed; {}",
                            error, std::string(to_string(result.status)))}});
  return error;
}

} // namespace

void report_reference(bool quick, BenchReport& report) {
  press_a_ball(quick, report);
  const std::string of = "displacement, relative L2, against deal.II's quadratic elements";
  const auto plane = [&](int per_mm) { return error_of_contact(0.25, 9.75, per_mm, report); };
  const auto punch = [&](int per_mm) { return error_of_contact(1, 6, per_mm, report); };
  report.checks.push_back({"fem_same_contact_plane_error", plane(1), "0.005", of});
  double of_punch = punch(1);
  if (!quick)
    for (const int per_mm : {2, 3})
      of_punch = punch(per_mm);
  report.checks.push_back({"fem_same_contact_punch_error", of_punch,
                           "0.017: as the cells under its edge are long, 0.05 with 5 across the punch",
                           of + "; 15 cells across the punch"});
}

} // namespace maille::lab
