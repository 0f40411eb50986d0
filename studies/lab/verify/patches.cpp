#include "verify/problems.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace maille::lab {

namespace {

/// A displacement that is linear in the place, of no symmetry.
Vec3 linear(const Vec3& x, int dimension) {
  constexpr double gradient[3][3] = {{0.02, -0.01, 0.005}, {0.015, -0.01, 0.02}, {-0.005, 0.01, 0.03}};
  Vec3 u{1e-4, -2e-4, 3e-4};
  for (std::size_t b = 0; b < 3; ++b)
    for (std::size_t a = 0; a < static_cast<std::size_t>(dimension); ++a)
      u[b] += gradient[b][a] * x[a];
  return u;
}

bool is_at_the_boundary(const Grid& grid, const Index3& node) {
  for (std::size_t a = 0; a < static_cast<std::size_t>(grid.dimension()); ++a)
    if (node[a] == 0 || node[a] == grid.nodes()[a] - 1)
      return true;
  return false;
}

/// Every node of the boundary where the linear displacement has it.
void prescribe_boundary(Scene& scene) {
  const Grid& grid = scene.specimen.grid;
  scene.prescribed.clear();
  for (int b = 0; b < scene.dimension(); ++b)
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
      if (const Index3 at = grid.node_at(node); is_at_the_boundary(grid, at))
        scene.prescribed.push_back(
            {node, b, linear(scene.specimen.position(at), scene.dimension())[static_cast<std::size_t>(b)],
             false});
}

double largest_error(const Scene& scene, const Displacement& u) {
  double error = 0, largest = 0;
  for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node) {
    const Vec3 expected =
        linear(scene.specimen.position(scene.specimen.grid.node_at(node)), scene.dimension());
    for (int b = 0; b < scene.dimension(); ++b) {
      error = std::max(error, std::abs(u(b, node) - expected[static_cast<std::size_t>(b)]));
      largest = std::max(largest, std::abs(expected[static_cast<std::size_t>(b)]));
    }
  }
  return error / largest;
}

} // namespace

void verify_patches(Verification& verification) {
  const std::string transverse =
      "{ E_fibre = \"100 kPa\", E_cross = \"10 kPa\", G_fibre = \"7 kPa\", nu_fibre = 0.3, nu_cross = 0.4 }";
  const std::string orthotropic = "{ E = [\"50 kPa\", \"20 kPa\", \"10 kPa\"], nu = [0.3, 0.25, 0.35], "
                                  "G = [\"12 kPa\", \"9 kPa\", \"5 kPa\"] }";
  const std::vector<std::pair<std::string, std::string>> matters{
      {"isotropic", "{ youngs_modulus = \"10 kPa\", poisson_ratio = 0.45 }"},
      {"transversely isotropic, turned", transverse},
      {"orthotropic, turned", orthotropic}};
  for (const int dimension : {2, 3})
    for (const auto& [name, matter] : matters) {
      Scene scene = Verification::scene(
          fmt::format("[specimen]\nshape = \"box\"\ncells = {}\nspacing = {}\nmaterial = {}\nfibre = "
                      "{}\n[[move]]\nwhere = \"x-\"\n"
                      "by = 0\n",
                      dimension == 2 ? "[5, 4]" : "[4, 4, 3]",
                      dimension == 2 ? "[\"1 mm\", \"1.3 mm\"]" : "[\"1 mm\", \"1.3 mm\", \"0.8 mm\"]",
                      matter, dimension == 2 ? "[0.8, 0.6, 0]" : "[0.8, 0.5, 0.3]"));
      prescribe_boundary(scene);
      VerificationRow row;
      row.problem = fmt::format("patch, {}, {}D", name, dimension);
      row.quantity = "largest error over largest displacement";
      row.is_absolute = true;
      row.source = "a linear displacement solves the equations, whatever the material";
      for (const std::string& method : verification.methods())
        if (const auto answer = verification.answer(scene, method, row)) {
          row.method = method;
          row.tolerance = method == "calculix" ? 1e-6 : 1e-10;
          row.computed = largest_error(scene, answer->displacement);
          verification.add(row);
        }
    }
}

} // namespace maille::lab
