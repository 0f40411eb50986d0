#pragma once
/// Scenes and helpers that the tests of fem_ref share.

#include "support/bodies/scenes.hpp"
#include "support/fields.hpp"

#include "maille/fem_ref/solve.hpp"

#include <cmath>
#include <random>
#include <stdexcept>

namespace maille::test {

/// Muscle-like: ten times stiffer along the fibre.
inline ElasticConstants fibrous() {
  return ElasticConstants::transversely_isotropic(100e3, 10e3, 4e3, 0.3, 0.4);
}

inline ElasticConstants orthotropic() {
  ElasticConstants c;
  c.youngs_modulus = {40e3, 15e3, 8e3};
  c.nu12 = 0.3, c.nu13 = 0.35, c.nu23 = 0.25;
  c.G12 = 7e3, c.G13 = 5e3, c.G23 = 3e3;
  return c;
}

/// No fibre along an axis, none in a plane of two.
inline Vec3 slanted_fibre(int dimension) {
  const Vec3 f = dimension == 3 ? Vec3{2, -1, 1.5} : Vec3{2, -1, 0};
  const double length = std::hypot(f[0], f[1], f[2]);
  return {f[0] / length, f[1] / length, f[2] / length};
}

/// Takes cells out of a box: each with the given chance, by a fixed seed.
inline void carve(Scene& scene, unsigned seed, double chance) {
  std::mt19937 random(seed);
  Specimen& specimen = scene.specimen;
  specimen.material_id.assign(static_cast<std::size_t>(specimen.grid.n_cells()), 0);
  for (std::uint8_t& material : specimen.material_id)
    if (static_cast<double>(random()) < chance * static_cast<double>(std::mt19937::max()))
      material = no_material;
}

inline fem_ref::Options options_of(int degree,
                                   fem_ref::LinearSolver solver = fem_ref::LinearSolver::automatic) {
  fem_ref::Options options;
  options.degree = degree;
  options.solver = solver;
  options.tolerance = 1e-12;
  return options;
}

/// A result that is done: any other ends the test.
inline fem_ref::Result solved(const Scene& scene, const fem_ref::Options& options,
                              const Control& control = {}) {
  fem_ref::Result result = fem_ref::solve(scene, options, control);
  if (result.answer.status != Status::done)
    throw std::runtime_error("the answer is not done: " + result.answer.message);
  return result;
}

/// Largest difference from a field over the nodes of the body.
template<class Field>
double largest_error(const Scene& scene, const Displacement& u, const Field& exact) {
  double most = 0;
  const Grid& grid = scene.specimen.grid;
  for (std::int64_t n = 0; n < grid.n_nodes(); ++n) {
    if (!scene.specimen.is_node(grid.node_at(n)))
      continue;
    const Vec3 expected = exact(scene.specimen.position(grid.node_at(n)));
    for (int c = 0; c < scene.dimension(); ++c)
      most = std::max(most, std::abs(u(c, n) - expected[static_cast<std::size_t>(c)]));
  }
  return most;
}

} // namespace maille::test
