// Smooth displacements whose body force is known in closed form: the error falls with the order of the element.
#include "fem_ref/bodies.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace maille {
namespace {

using test::options_of;

/// u_k = amplitude_k sin(wave_k . x + phase_k): smooth, nowhere zero on the boundary, easy to differentiate.
struct Waves {
  Vec3 amplitude{0.01, -0.02, 0.015};
  std::array<Vec3, 3> wave{{{2.0, 1.0, -1.5}, {-1.0, 2.5, 1.0}, {1.5, -1.0, 2.0}}};
  Vec3 phase{0.3, 1.1, 2.0};

  double angle(std::size_t k, const Vec3& x, int dimension) const {
    double sum = phase[k];
    for (std::size_t a = 0; a < static_cast<std::size_t>(dimension); ++a)
      sum += wave[k][a] * x[a];
    return sum;
  }
  Vec3 displacement(const Vec3& x, int dimension) const {
    Vec3 u{};
    for (std::size_t k = 0; k < static_cast<std::size_t>(dimension); ++k)
      u[k] = amplitude[k] * std::sin(angle(k, x, dimension));
    return u;
  }
  /// f_i = -C_ijkl d_j d_l u_k, with d_j d_l u_k = -wave_kj wave_kl u_k.
  Vec3 body_force(const Eigen::MatrixXd& C, const Vec3& x, int dimension) const {
    const int voigt3[3][3] = {{0, 5, 4}, {5, 1, 3}, {4, 3, 2}};
    const int voigt2[2][2] = {{0, 2}, {2, 1}};
    const auto index = [&](int i, int j) {
      return dimension == 3 ? voigt3[i][j] : dimension == 2 ? voigt2[i][j] : 0;
    };
    const Vec3 u = displacement(x, dimension);
    Vec3 f{};
    for (int i = 0; i < dimension; ++i)
      for (int j = 0; j < dimension; ++j)
        for (int k = 0; k < dimension; ++k)
          for (int l = 0; l < dimension; ++l) {
            const auto kk = static_cast<std::size_t>(k);
            f[static_cast<std::size_t>(i)] += C(index(i, j), index(k, l)) *
                                              wave[kk][static_cast<std::size_t>(j)] *
                                              wave[kk][static_cast<std::size_t>(l)] * u[kk];
          }
    return f;
  }
};

double error(int dimension, int cells, int degree, const ElasticConstants& constants) {
  const double h = 1.0 / cells;
  Scene scene = test::box_scene(dimension, {cells, cells, cells}, {h, h, h});
  scene.materials[0] = test::material_of(constants);
  scene.specimen.fibre = test::slanted_fibre(dimension);
  const Waves waves;
  const Eigen::MatrixXd C = scene.cell_stiffness(0);
  fem_ref::Options options = options_of(degree);
  options.exact = [=](const Vec3& x) { return waves.displacement(x, dimension); };
  options.boundary_displacement = options.exact;
  options.body_force = [=](const Vec3& x) { return waves.body_force(C, x, dimension); };
  return fem_ref::solve(scene, options).l2_error.value();
}

// Truth: |u - u_h| in L2 falls as h^(degree + 1) (Ciarlet 1978, theorem 3.2.5).
TEST(ManufacturedAnalytic, ErrorFallsWithTheOrderOfTheElement) {
  for (int dimension = 1; dimension <= 3; ++dimension)
    for (const int degree : {1, 2})
      for (const bool is_fibrous : {false, true}) {
        const ElasticConstants matter = is_fibrous ? test::fibrous() : ElasticConstants::isotropic(10e3, 0.3);
        const int cells = (dimension == 3 ? 8 : 16) / degree;
        const double coarse = error(dimension, cells, degree, matter);
        const double fine = error(dimension, 2 * cells, degree, matter);
        EXPECT_NEAR(std::log2(coarse / fine), degree + 1, 0.15)
            << fmt::format("{}D Q{} {}: {:.3g} {:.3g}", dimension, degree,
                           is_fibrous ? "fibrous" : "isotropic", coarse, fine);
      }
}

// Truth: the cantilever of Timoshenko and Goodier 1951, article 21 (plane stress, end load P on depth D), which
// solves the equations without body force; origin in the middle of the fixed end.
TEST(ManufacturedAnalytic, PlaneStressCantileverConverges) {
  const double E = 10e3, nu = 0.3, P = 2.0, L = 4.0, D = 1.0, I = D * D * D / 12;
  const auto exact = [=](const Vec3& x) -> Vec3 {
    const double y = x[1];
    return {
        P * y / (6 * E * I) * ((6 * L - 3 * x[0]) * x[0] + (2 + nu) * (y * y - D * D / 4)),
        -P / (6 * E * I) *
            (3 * nu * y * y * (L - x[0]) + (4 + 5 * nu) * D * D * x[0] / 4 + (3 * L - x[0]) * x[0] * x[0]),
        0};
  };
  for (const int degree : {1, 2}) {
    std::vector<double> errors;
    for (const int cells : {4, 8}) {
      const double h = D / cells;
      Scene scene = test::box_scene(2, {4 * cells, cells, 1}, {h, h, h});
      scene.specimen.origin = {0, -D / 2, 0};
      scene.plane = PlaneAssumption::stress;
      fem_ref::Options options = options_of(degree);
      options.boundary_displacement = exact;
      options.exact = exact;
      errors.push_back(fem_ref::solve(scene, options).l2_error.value());
    }
    EXPECT_NEAR(std::log2(errors[0] / errors[1]), degree + 1, 0.15);
  }
}

} // namespace
} // namespace maille
