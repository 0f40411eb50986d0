#include "maille/fem_ref/solve.hpp"
#include "verify/problems.hpp"

#include <array>
#include <cmath>
#include <fmt/format.h>

namespace maille::studies {

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

/// L2 norm of the error on a unit cube of so many cells a side; not a number where there is no answer.
double error_on(int dimension, int cells, int degree, const std::string& matter) {
  std::string sides;
  for (int a = 0; a < dimension; ++a)
    sides += fmt::format("{}{}", a > 0 ? ", " : "", cells);
  const Scene scene = Verification::scene(
      fmt::format("[specimen]\nshape = \"box\"\ncells = [{}]\nspacing = {}\nmaterial = {}\nfibre = "
                  "{}\n[[hold]]\nwhere = \"x-\"\n",
                  sides, 1.0 / cells, matter, dimension == 3 ? "[2, -1, 1.5]" : "[2, -1, 0]"));
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
      for (const int degree : {1, 2}) {
        // Not so fine that rounding, nor so coarse that the next order, decides.
        const int cells = (dimension == 3 && verification.is_quick() ? 6 : dimension == 3 ? 8 : 16) / degree;
        const double coarse = error_on(dimension, cells, degree, matter),
                     fine = error_on(dimension, 2 * cells, degree, matter);
        VerificationRow row;
        row.problem = fmt::format("manufactured solution, {}, {}D", name, dimension);
        row.method = fmt::format("fem_q{}", degree);
        row.quantity = fmt::format("order in L2, {} and {} cells a side", cells, 2 * cells);
        row.expected = degree + 1;
        row.computed = std::log2(coarse / fine);
        row.tolerance = 0.15;
        row.is_absolute = true;
        row.source = "Ciarlet 1978, theorem 3.2.5: the error falls as h^(degree + 1)";
        verification.add(std::move(row));
      }
}

} // namespace maille::studies
