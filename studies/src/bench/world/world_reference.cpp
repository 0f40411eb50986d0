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

namespace maille::studies {

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
       std::max(std::abs(force / truth.force - 1), std::abs(contact_radius / truth.radius - 1)), 0.05, false,
       "0.03: cells of a fifth of the contact's radius",
       "the larger error of force and radius of contact, pressed by a tenth of the radius into a block on "
       "rigid ground"});
}

/// A block under a tool that is as wide as it or narrower, in a world of a quarter of its cells; quadratic
/// elements get the nodes that touch where the world has put them.
double error_of_contact(int width, BenchReport& report) {
  const double corner = std::round((10.1 - 0.5 * width) / 0.25) * 0.25;
  const std::string text = fmt::format(
      "[world]\ncells = [80, 80, 64]\nspacing = \"0.25 mm\"\n[[object]]\nname = \"block\"\nkind = "
      "\"deformable\"\nshape = \"box\"\ncells = [12, 12, 8]\nspacing = \"1 mm\"\nmaterial = {{ "
      "youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }}\nhold = [{{ where = \"z-\" }}]\nposition = [\"4.1 "
      "mm\", \"4.1 mm\", \"2.1 mm\"]\n[[object]]\nname = \"tool\"\nkind = \"rigid\"\nshape = \"box\"\ncells "
      "= "
      "[{0}, {0}, 3]\nposition = [\"{1} mm\", \"{1} mm\", \"10.75 mm\"]\n",
      4 * width, corner);
  World world(parse_world_scene(text));
  Drive drive;
  drive.object = 1;
  drive.motion.by = {0, 0, -1.75 * mm};
  const FrameResult result = world.advance({&drive, 1});
  Scene scene = world.scene().objects[0].scene;
  for (const auto& contact : result.contacts)
    if (contact.object == 0)
      scene.prescribed.push_back({contact.voxel, 2, world.displacement(0)(2, contact.voxel), false});
  std::ranges::sort(scene.prescribed, {}, [](const Prescribed& p) { return std::pair(p.component, p.node); });
  fem_ref::Options options;
  options.degree = 2;
  const Answer answer = fem_ref::solve(scene, options).answer;
  const double error = is_converged(answer.status)
                           ? compare(scene, world.displacement(0), answer.displacement).relative_l2
                           : 1;
  report.add(
      {{"what", width > 12 ? "a plane on a block" : "a flat punch on a block"},
       {"voxels", static_cast<std::int64_t>(result.contacts.size())},
       {"microseconds", 1e6 * result.seconds},
       {"ns_per_voxel",
        1e9 * result.seconds / std::max<double>(1, static_cast<double>(result.contacts.size()))},
       {"note", fmt::format("a contact in place of a voxel; {:.3g} off quadratic elements with the same "
                            "nodes prescribed",
                            error)}});
  return error;
}

} // namespace

void report_reference(bool quick, BenchReport& report) {
  press_a_ball(quick, report);
  report.checks.push_back({"fem_same_contact_plane_error", error_of_contact(16, report), 0.02, false, "0.005",
                           "displacement, relative L2, against deal.II's quadratic elements"});
  report.checks.push_back({"fem_same_contact_punch_error", error_of_contact(5, report), 0.02, false,
                           "0.07: cells of a fifth of the punch under its edge",
                           "displacement, relative L2, against deal.II's quadratic elements"});
}

} // namespace maille::studies
