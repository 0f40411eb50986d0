#include "verify/problems.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <numbers>

namespace maille::lab {

namespace {

constexpr double E = 10e3, nu = 0.3, pressure = 100, half_side = 4e-3;

/// Displacement of a half space z < 0 at (x, y, z) under a force of 1 N at the origin, downwards.
/// Boussinesq 1885, as in Timoshenko and Goodier 1951, article 138.
Vec3 under_point_load(double x, double y, double z) {
  const double G = E / (2 * (1 + nu)), depth = -z, R = std::sqrt(x * x + y * y + z * z);
  const double outwards =
      (depth / (R * R * R) - (1 - 2 * nu) / (R * (R + depth))) / (4 * std::numbers::pi * G);
  const double down = (depth * depth / (R * R * R) + 2 * (1 - nu) / R) / (4 * std::numbers::pi * G);
  return {x * outwards, y * outwards, -down};
}

/// The same under the pressure on the square, by a Gauss rule of 4 x 4 points on each of 8 x 8 parts of it;
/// points are some way from the square.
Vec3 under_square(const Vec3& at) {
  constexpr std::array<double, 4> place{-0.861136311594053, -0.339981043584856, 0.339981043584856,
                                        0.861136311594053};
  constexpr std::array<double, 4> weight{0.347854845137454, 0.652145154862546, 0.652145154862546,
                                         0.347854845137454};
  constexpr int parts = 8;
  constexpr double half = half_side / parts;
  Vec3 sum{0, 0, 0};
  for (int i = 0; i < parts; ++i)
    for (int j = 0; j < parts; ++j)
      for (std::size_t p = 0; p < 4; ++p)
        for (std::size_t q = 0; q < 4; ++q) {
          const double x = -half_side + (2 * i + 1 + place[p]) * half,
                       y = -half_side + (2 * j + 1 + place[q]) * half;
          const Vec3 u = under_point_load(at[0] - x, at[1] - y, at[2]);
          for (std::size_t a = 0; a < 3; ++a)
            sum[a] += weight[p] * weight[q] * half * half * pressure * u[a];
        }
  return sum;
}

/// A quarter of a block of n^3 cells under the corner of the square, whose cut faces move as the half space
/// does there.
Scene block(int n, double spacing) {
  Scene scene = Verification::scene(
      fmt::format("[specimen]\nshape = \"box\"\ncells = [{0}, {0}, {0}]\nspacing = {1}\n"
                  "material = {{ youngs_modulus = {2}, poisson_ratio = {3} }}\n"
                  "[[hold]]\nwhere = \"x-\"\naxes = \"x\"\n[[hold]]\nwhere = \"y-\"\naxes = \"y\"\n"
                  "[[hold]]\nwhere = \"z-\"\n[[hold]]\nwhere = \"x+\"\n[[hold]]\nwhere = \"y+\"\n"
                  "[[load]]\nwhere = {{ box = [[0, 0, {4}], [{5}, {5}, {4}]] }}\ntraction = [0, 0, -{6}]\n",
                  n, spacing, E, nu, n * spacing, half_side, pressure));
  const Grid& grid = scene.specimen.grid;
  for (Prescribed& p : scene.prescribed) {
    const Index3 at = grid.node_at(p.node);
    Vec3 x = scene.specimen.position(at);
    x[2] -= n * spacing;
    if (std::max(at[0], at[1]) == n || at[2] == 0) {
      p.value = under_square(x)[static_cast<std::size_t>(p.component)];
      p.held = false;
    }
  }
  return scene;
}

} // namespace

void verify_indentation(Verification& verification) {
  const int n = verification.is_quick() ? 16 : 24;
  const double spacing = 1e-3;
  const Scene scene = block(n, spacing);
  VerificationRow row;
  row.problem = "half space under pressure on a square";
  row.quantity = "depth of the middle [m]";
  row.expected =
      8 / std::numbers::pi * std::log1p(std::numbers::sqrt2) * (1 - nu * nu) * pressure * half_side / E;
  row.source = "Love 1929, 8 / pi ln(1 + sqrt 2) (1 - nu^2) p a / E for a square of side 2 a = 8 cells; a "
               "block of 6 a, whose cut faces "
               "move as Boussinesq's half space does there, so that no correction for its size is left";
  for (const std::string& method : verification.methods())
    if (const auto answer = verification.answer(scene, method, row)) {
      row.method = method;
      row.tolerance = method == "fem_q2" ? 0.0005 : 0.004;
      row.computed = -answer->displacement(2, scene.specimen.grid.node({0, 0, n}));
      verification.add(row);
    }
}

} // namespace maille::lab
