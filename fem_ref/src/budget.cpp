#include "kept_problem.hpp"

#include "finite/finite_problem.hpp"
#include "maille/base/arena.hpp"
#include "maille/fem_ref/ranks.hpp"
#include "maille/mechanics/friction.hpp"
#include "maille/scene/plausibility.hpp"
#include "solvers/multigrid_mesh.hpp"

#include <fmt/format.h>

#include <cmath>

namespace maille::fem_ref {

bool wants_multigrid(const Scene& scene, const Options& options) {
  if (options.shape || scene.strain == Strain::finite)
    return false;
  constexpr std::int64_t largest_bottom = 6000;
  constexpr double least_nodes = 4000; // a factor is faster below
  if (options.solver == LinearSolver::gmg)
    return why_no_hierarchy(scene).empty();
  return options.solver == LinearSolver::automatic && scene.dimension() == 3 &&
         static_cast<double>(scene.specimen.n_matter_cells()) * std::pow(options.degree, 3) >= least_nodes &&
         why_no_hierarchy(scene).empty() && coarsest_unknowns(scene, options.degree) <= largest_bottom;
}

namespace {

/// Lower bound of the memory of any solver with a matrix in 3D: the matrix, its copy in Trilinos and the
/// hierarchy.
double bytes_at_least(const Scene& scene, const Options& options) {
  const int d = scene.dimension();
  const double nodes = static_cast<double>(scene.specimen.n_matter_nodes()) * std::pow(options.degree, d);
  const double coupled_nodes = std::pow(options.degree + 2, d); // coupled nodes per interior node, on average
  const double bytes_per_entry = 35; // process memory per entry: 50 at 32^3 cells Q1, 35 at 16^3 cells Q2
  const double bytes_per_node_of_meshes = 2000;
  if (wants_multigrid(scene, options))
    return bytes_per_node_of_meshes * nodes;
  return bytes_per_entry * nodes * coupled_nodes * d * d;
}

} // namespace

std::string why_refused(const Scene& scene, const Options& options) {
  if (options.degree != 1 && options.degree != 2)
    return fmt::format("expected elements of degree 1 or 2, found {}", options.degree);
  if (scene.dimension() < 1 || scene.dimension() > 3 || scene.specimen.n_matter_cells() == 0)
    return "the specimen holds no matter";
  if (std::string reason = unusable_number(scene); !reason.empty())
    return reason;
  if (options.degree == 2 && has_friction(scene.tied))
    return "friction of sliding borders is between the corners of cells: linear elements and coupled know "
           "it, quadratic ones do not";
  if (std::string reason = why_no_finite_strain(scene, options); !reason.empty())
    return reason;
  if (options.shape && (options.body_force || options.exact))
    return "a shape cannot be combined with a body force or an exact solution";
  if (options.solver == LinearSolver::gmg)
    if (std::string reason = options.shape ? "the body has a shape" : why_no_hierarchy(scene);
        !reason.empty())
      return "no geometric multigrid: " + reason;
  const double needed = bytes_at_least(scene, options) / ranks().machines;
  if (const auto available = static_cast<double>(available_memory()); needed > available)
    return fmt::format("matrix and solver need about {}, {} are available", bytes_in_words(needed),
                       bytes_in_words(available));
  if (!options.boundary_displacement) {
    if (scene.prescribed.empty() && scene.springs.empty())
      return "nothing is held or moved, so the body can move anywhere";
    if (std::string motion = remaining_rigid_motion(scene); !motion.empty())
      return motion + ": hold or move more of it";
  }
  return {};
}

/// Cost per unknown. Boxes by multigrid: 2 to 4 us and 250 to 650 bytes. Other bodies in 3D (CG with AMG): 27
/// us and 4 KiB with linear, 60 us and 6.5 KiB with quadratic elements; in 2D (factor): 8 us. Contrast
/// between materials makes iterations more expensive.
Estimate estimate(const Scene& scene, const Options& options) {
  const int d = scene.dimension();
  const double unknowns =
      d * static_cast<double>(scene.specimen.n_matter_nodes()) * std::pow(options.degree, d);
  if (wants_multigrid(scene, options))
    return {5e-6 * unknowns, 700 * unknowns};
  if (scene.strain == Strain::finite) // about fifteen tangents
    return {1e-3 * unknowns, 1.6 * bytes_at_least(scene, options)};
  if (d < 3)
    return {1.5e-5 * unknowns, 2500 * unknowns};
  const double growth = scene.materials.size() > 1 ? 2 : 1;
  return {growth * (options.degree == 1 ? 3e-5 : 7e-5) * unknowns, 1.6 * bytes_at_least(scene, options)};
}

} // namespace maille::fem_ref
