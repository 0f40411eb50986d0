// A displacement that is known everywhere: the error falls with the order of the element. More in
// studies/lab/verify/orders.cpp.
#include "fem_ref/bodies.hpp"
#include "maille/scene/cell_fields.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace maille {
namespace {

using test::options_of;

// Truth: the cantilever of Timoshenko and Goodier 1951, article 21 (plane stress, end load P on depth D),
// which solves the equations without body force; origin in the middle of the fixed end.
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

// Truth: quadratic elements hold a quadratic displacement exactly; its strain is linear, so a cell's mean is
// that at its middle, and the stress that of the mean.
TEST(CellStrainAnalytic, QuadraticElementsGiveTheirOwnMeans) {
  for (const int dimension : {2, 3}) {
    const Scene scene = test::box_scene(dimension, {3, 2, dimension == 3 ? 2 : 1}, {1e-3, 1.5e-3, 2e-3});
    const auto n = static_cast<std::size_t>(dimension);
    const double bend[3][3] = {{7, -4, 3}, {2, 6, -5}, {-3, 1, 8}};
    const auto exact = [&](const Vec3& x) -> Vec3 {
      Vec3 u{};
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j)
          u[i] += bend[i][j] * x[j] * x[(j + i) % n];
      return u;
    };
    const auto strain = [&](const Vec3& x) {
      Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j) {
          const std::size_t k = (j + i) % n;
          gradient(static_cast<int>(i), static_cast<int>(j)) += bend[i][j] * x[k];
          gradient(static_cast<int>(i), static_cast<int>(k)) += bend[i][j] * x[j];
        }
      return Eigen::Matrix3d((gradient + gradient.transpose()) / 2);
    };
    const auto stress = [&](const Vec3& x) {
      const Eigen::Matrix3d e = strain(x);
      Vector6 voigt;
      voigt << e(0, 0), e(1, 1), e(2, 2), 2 * e(1, 2), 2 * e(0, 2), 2 * e(0, 1);
      const Vector6 s = scene.object_stiffness(0) * voigt;
      Eigen::Matrix3d tensor;
      tensor << s(0), s(5), s(4), s(5), s(1), s(3), s(4), s(3), s(2);
      return tensor;
    };
    Vec3 force{};
    for (std::size_t j = 0; j < n; ++j) {
      Vec3 one{};
      one[j] = 1;
      const Eigen::Matrix3d slope = stress(one) - stress({});
      for (std::size_t i = 0; i < n; ++i)
        force[i] -= slope(static_cast<int>(i), static_cast<int>(j));
    }
    fem_ref::Options options = options_of(2);
    options.boundary_displacement = exact;
    options.body_force = [&](const Vec3&) { return force; };
    const Answer answer = fem_ref::solve(scene, options).answer;
    ASSERT_EQ(answer.status, Status::done) << answer.message;
    const CellFields own = cell_fields(scene, answer);
    double largest = 0;
    const Grid& grid = scene.specimen.grid;
    for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
      Vec3 middle = scene.specimen.position(grid.cell_at(cell));
      for (std::size_t a = 0; a < n; ++a)
        middle[a] += grid.spacing()[a] / 2;
      const Eigen::Matrix3d e = strain(middle), s = stress(middle);
      const auto c = static_cast<std::size_t>(cell);
      constexpr int row[6] = {0, 1, 2, 0, 1, 0}, column[6] = {0, 1, 2, 1, 2, 2};
      for (std::size_t k = 0; k < 6; ++k) {
        EXPECT_NEAR(own.strain[c][k], e(row[k], column[k]), 1e-9 * 0.05);
        EXPECT_NEAR(own.stress[c][k], s(row[k], column[k]), 1e-9 * 0.05 * 1e6);
        largest = std::max(largest, std::abs(e(row[k], column[k])));
      }
    }
    EXPECT_GT(largest, 0.01);
  }
}

} // namespace
} // namespace maille
