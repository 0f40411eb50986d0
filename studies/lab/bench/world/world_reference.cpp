#include "bench/subjects.hpp"
#include "bench/world/ball_on_layer.hpp"
#include "maille/deform/world/world.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace maille::lab {

namespace {

using deform::Drive;
using deform::FrameResult;
using deform::World;

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

} // namespace

void report_reference(bool quick, BenchReport& report) {
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

} // namespace maille::lab
