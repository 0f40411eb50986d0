#include "compare/methods.hpp"
#include "maille/fem_ref/solve.hpp"
#include "verify/problems.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

namespace maille::lab {

namespace {

/// u_k = amplitude_k sin(wave_k . x + phase_k): smooth, nowhere zero on the boundary, easy to differentiate.
struct Waves {
  Vec3 amplitude{0.01, -0.02, 0.015};
  std::array<Vec3, 3> wave{{{2.0, 1.0, -1.5}, {-1.0, 2.5, 1.0}, {1.5, -1.0, 2.0}}};
  Vec3 phase{0.3, 1.1, 2.0};

  Vec3 displacement(const Vec3& x, int dimension) const {
    Vec3 u{};
    for (std::size_t k = 0; k < static_cast<std::size_t>(dimension); ++k) {
      double angle = phase[k];
      for (std::size_t a = 0; a < static_cast<std::size_t>(dimension); ++a)
        angle += wave[k][a] * x[a];
      u[k] = amplitude[k] * std::sin(angle);
    }
    return u;
  }
  /// f_i = -C_ijkl d_j d_l u_k, with d_j d_l u_k = -wave_kj wave_kl u_k.
  Vec3 body_force(const Eigen::MatrixXd& C, const Vec3& x, int dimension) const {
    constexpr int voigt3[3][3] = {{0, 5, 4}, {5, 1, 3}, {4, 3, 2}};
    constexpr int voigt2[2][2] = {{0, 2}, {2, 1}};
    const auto index = [&](int i, int j) {
      return dimension == 3 ? voigt3[i][j] : dimension == 2 ? voigt2[i][j] : 0;
    };
    const Vec3 u = displacement(x, dimension);
    Vec3 f{};
    for (int i = 0; i < dimension; ++i)
      for (int j = 0; j < dimension; ++j)
        for (int k = 0; k < dimension; ++k)
          for (int l = 0; l < dimension; ++l) {
            const auto of = static_cast<std::size_t>(k);
            f[static_cast<std::size_t>(i)] += C(index(i, j), index(k, l)) *
                                              wave[of][static_cast<std::size_t>(j)] *
                                              wave[of][static_cast<std::size_t>(l)] * u[of];
          }
    return f;
  }
};

/// A unit cube with `cells` cells a side.
Scene cube(int dimension, int cells, const std::string& matter) {
  std::string sides;
  for (int a = 0; a < dimension; ++a)
    sides += fmt::format("{}{}", a > 0 ? ", " : "", cells);
  return Verification::scene(
      fmt::format("[specimen]\nshape = \"box\"\ncells = [{}]\nspacing = {}\nmaterial = {}\nfibre = "
                  "{}\n[[hold]]\nwhere = \"x-\"\n",
                  sides, 1.0 / cells, matter, dimension == 3 ? "[2, -1, 1.5]" : "[2, -1, 0]"));
}

/// L2 norm of the error of finite elements; not a number where there is no answer.
double error_of_elements(int dimension, int cells, int degree, const std::string& matter) {
  const Scene scene = cube(dimension, cells, matter);
  const Waves waves;
  const Eigen::MatrixXd C = scene.cell_stiffness(0);
  fem_ref::Options options;
  options.degree = degree;
  options.tolerance = 1e-12;
  options.exact = [=](const Vec3& x) { return waves.displacement(x, dimension); };
  options.boundary_displacement = options.exact;
  options.body_force = [=](const Vec3& x) { return waves.body_force(C, x, dimension); };
  return fem_ref::solve(scene, options).l2_error.value_or(std::numeric_limits<double>::quiet_NaN());
}

bool is_on_boundary(const Grid& grid, const Index3& node) {
  for (std::size_t a = 0; a < static_cast<std::size_t>(grid.dimension()); ++a)
    if (node[a] == 0 || node[a] == grid.cells()[a])
      return true;
  return false;
}

/// The same of `coupled`, summed over the nodes. A scene knows no body force that varies: half of a cell's
/// force, by its value in the middle, pulls at either of its faces across x, inside the body too.
double error_of_coupled(int dimension, int cells, const std::string& matter) {
  Scene scene = cube(dimension, cells, matter);
  const Grid& grid = scene.specimen.grid;
  Waves waves;
  for (double& amplitude : waves.amplitude)
    amplitude *= 1e-4; // the lattice turns with its handles, which is of second order in what they do
  const Eigen::MatrixXd C = scene.cell_stiffness(0);
  scene.prescribed.clear();
  for (int c = 0; c < dimension; ++c)
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
      if (const Index3 at = grid.node_at(node); is_on_boundary(grid, at))
        scene.prescribed.push_back(
            {node, c, waves.displacement(scene.specimen.position(at), dimension)[static_cast<std::size_t>(c)],
             false});
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    Vec3 middle = scene.specimen.position(grid.cell_at(cell));
    for (std::size_t a = 0; a < static_cast<std::size_t>(dimension); ++a)
      middle[a] += 0.5 / cells;
    Vec3 traction = waves.body_force(C, middle, dimension);
    for (double& t : traction)
      t *= 0.5 / cells;
    scene.tractions.push_back({cell, 0, false, traction});
    scene.tractions.push_back({cell, 0, true, traction});
  }
  const Answer answer = answer_by(scene, "coupled", {});
  if (!is_converged(answer.status))
    return std::numeric_limits<double>::quiet_NaN();
  double squared = 0;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    const Vec3 exact = waves.displacement(scene.specimen.position(grid.node_at(node)), dimension);
    for (int c = 0; c < dimension; ++c)
      squared += std::pow(answer.displacement(c, node) - exact[static_cast<std::size_t>(c)], 2);
  }
  return std::sqrt(squared / std::pow(cells, dimension));
}

} // namespace

void verify_orders(Verification& verification) {
  const std::vector<std::pair<std::string, std::string>> matters{
      {"isotropic", "{ youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }"},
      {"transversely isotropic, turned", "{ E_fibre = \"100 kPa\", E_cross = \"10 kPa\", G_fibre = \"4 "
                                         "kPa\", nu_fibre = 0.3, nu_cross = 0.4 }"},
      {"orthotropic, turned", "{ E = [\"40 kPa\", \"15 kPa\", \"8 kPa\"], nu = [0.3, 0.35, 0.25], "
                              "G = [\"7 kPa\", \"5 kPa\", \"3 kPa\"] }"}};
  for (int dimension = 1; dimension <= 3; ++dimension)
    for (const auto& [name, matter] : matters)
      for (const int degree : {0, 1, 2}) { // 0: coupled
        // Not so fine that rounding, nor so coarse that the next order, decides.
        const int cells = (dimension == 3 && verification.is_quick() ? 6
                           : dimension == 3                          ? 8
                                                                     : 16) /
                          std::max(1, degree);
        const auto error = [&, &of_matter = matter](int n) {
          return degree == 0 ? error_of_coupled(dimension, n, of_matter)
                             : error_of_elements(dimension, n, degree, of_matter);
        };
        VerificationRow row;
        row.problem = fmt::format("manufactured solution, {}, {}D", name, dimension);
        row.method = degree == 0 ? "coupled" : fmt::format("fem_q{}", degree);
        row.quantity = fmt::format("order in L2, {} and {} cells a side", cells, 2 * cells);
        row.expected = std::max(1, degree) + 1;
        row.computed = std::log2(error(cells) / error(2 * cells));
        row.tolerance = 0.15;
        row.is_absolute = true;
        row.source =
            "Ciarlet 1978, theorem 3.2.5: the error falls as h^(degree + 1); `coupled` is of degree 1";
        verification.add(std::move(row));
      }
}

} // namespace maille::lab
