#include "elastic/model/lattice_elasticity.hpp"

#include "support/bodies/scenes.hpp"
#include "support/fields.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace maille::deform {
namespace {

double uniform(std::mt19937& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random()) / static_cast<double>(std::mt19937::max());
}

/// A body with holes, of two materials that know no symmetry with the grid.
Scene odd_body(int dimension, unsigned seed) {
  std::mt19937 random(seed);
  Scene scene =
      test::box_scene(dimension, {4, dimension > 1 ? 3 : 1, dimension > 2 ? 3 : 1}, {1e-3, 1.4e-3, 0.7e-3});
  scene.materials[0].elasticity = ElasticConstants::transversely_isotropic(60e3, 10e3, 7e3, 0.3, 0.4);
  scene.materials.push_back(scene.materials[0]);
  scene.materials[1].elasticity = ElasticConstants::isotropic(25e3, 0.45);
  Specimen& body = scene.specimen;
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell) {
    const double chance = uniform(random, 0, 1);
    body.material_id.push_back(chance < 0.2 ? no_material : chance < 0.6 ? std::uint8_t{0} : std::uint8_t{1});
    const Eigen::Vector3f f =
        Eigen::Vector3f(static_cast<float>(uniform(random, -1, 1)),
                        dimension > 1 ? static_cast<float>(uniform(random, -1, 1)) : 0.0F,
                        dimension > 2 ? static_cast<float>(uniform(random, -1, 1)) : 0.0F)
            .normalized();
    body.fibres.push_back({f[0], f[1], f[2]});
  }
  body.material_id[0] = 0;
  return scene;
}

Displacement random_field(const Scene& scene, unsigned seed) {
  std::mt19937 random(seed);
  Displacement u(scene.specimen.grid);
  for (double& value : u.values())
    value = uniform(random, -1e-4, 1e-4);
  return u;
}

/// Whether the row of matter through a cell has one or two cells.
bool is_thin(const Specimen& body, const Index3& cell, int axis) {
  int in_a_row = 0, longest = 0;
  bool is_there = false;
  Index3 at = cell;
  const auto a = static_cast<std::size_t>(axis);
  for (at[a] = 0; at[a] < body.grid.cells()[a]; ++at[a]) { // the one run that has the cell in it
    const bool is_matter = body.is_matter(body.grid.cell(at));
    if (!is_matter && is_there)
      break;
    in_a_row = is_matter ? in_a_row + 1 : 0;
    is_there = is_there || at == cell;
    longest = in_a_row;
  }
  return longest <= 2;
}

/// The energy as the documentation writes it: cell by cell, term by term, strains from the positions of
/// corners.
double energy_by_the_formula(const Scene& scene, const Displacement& u) {
  const Grid& grid = scene.specimen.grid;
  const int d = grid.dimension(), corners = 1 << d;
  const Vec3& h = grid.spacing();
  const auto of = [](int a) { return static_cast<std::size_t>(a); };
  double volume = 1, total = 0;
  for (int a = 0; a < d; ++a)
    volume *= h[of(a)];
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    if (!scene.specimen.is_matter(cell))
      continue;
    const Index3 at = grid.cell_at(cell);
    const auto value = [&](int b, int corner) { return u(b, grid.corner(at, corner)); };
    /// Mean of d u_b / d x_a over the edges along a whose corners satisfy `is_in`.
    const auto slope = [&](int b, int a, auto is_in) {
      double sum = 0;
      int n = 0;
      for (int corner = 0; corner < corners; ++corner)
        if (!(corner & 1 << a) && is_in(corner)) {
          sum += (value(b, corner | 1 << a) - value(b, corner)) / h[of(a)];
          ++n;
        }
      return sum / n;
    };
    const auto everywhere = [](int) { return true; };
    const Eigen::MatrixXd C = scene.cell_stiffness(cell), S = C.inverse();
    Eigen::VectorXd strain = Eigen::VectorXd::Zero(C.rows());
    const int pairs[3][2] = {{1, 2}, {0, 2}, {0, 1}};
    for (int a = 0; a < d; ++a)
      strain[a] = slope(a, a, everywhere);
    for (int row = d; row < C.rows(); ++row) {
      const auto& [a, b] = pairs[d == 2 ? 2 : row - 3];
      strain[row] = slope(a, b, everywhere) + slope(b, a, everywhere);
    }
    Eigen::MatrixXd mean = C;
    for (int a = 0; a < d; ++a)
      mean(a, a) -= 1.0 / 3 / S(a, a);
    total += volume / 2 * strain.dot(mean * strain);
    for (int a = 0; a < d; ++a)
      for (int corner = 0; corner < corners; ++corner)
        if (!(corner & 1 << a)) {
          const double e = (value(a, corner | 1 << a) - value(a, corner)) / h[of(a)];
          total += 1.0 / 6 * volume / (corners / 2) / S(a, a) * e * e;
        }
    for (int pair = 0; d == 3 && pair < 3; ++pair) {
      const auto& [a, b] = pairs[pair];
      const auto upper = [&](int corner) { return (corner & 1 << pair) != 0; };
      const auto lower = [&](int corner) { return (corner & 1 << pair) == 0; };
      const double jump = slope(a, b, upper) + slope(b, a, upper) - slope(a, b, lower) - slope(b, a, lower);
      total += volume / 24 / S(3 + pair, 3 + pair) * jump * jump;
      if (!is_thin(scene.specimen, at, pair))
        continue;
      const int first = (pair + 1) % 3, second = (pair + 2) % 3;
      const Eigen::Vector3d faces(slope(first, first, upper) - slope(first, first, lower),
                                  slope(second, second, upper) - slope(second, second, lower), jump);
      const std::array<int, 3> rows{first, second, 3 + pair};
      const Eigen::Matrix3d across = S(rows, rows);
      total += volume / 24 * faces.dot(Eigen::Matrix3d(across.inverse()) * faces);
      for (int i = 0; i < 3; ++i)
        total -= volume / 24 / across(i, i) * faces[i] * faces[i];
    }
  }
  return total;
}

TEST(LatticeElasticityOracle, EnergyIsThatOfTheFormulaCellByCell) {
  for (int dimension = 1; dimension <= 3; ++dimension)
    for (unsigned seed = 1; seed <= 10; ++seed) {
      const Scene scene = odd_body(dimension, seed);
      const Displacement u = random_field(scene, seed + 100);
      Displacement forces(scene.specimen.grid);
      ThreadTeam team(1);
      LatticeElasticity(scene).apply(u, forces, team);
      const double expected = energy_by_the_formula(scene, u);
      EXPECT_NEAR(0.5 * test::product(u, forces), expected, 1e-12 * expected)
          << dimension << "D seed " << seed;
    }
}

TEST(LatticeElasticityOracle, TheOperatorIsSymmetricAndTheDiagonalItsOwn) {
  for (int dimension = 1; dimension <= 3; ++dimension) {
    const Scene scene = odd_body(dimension, 3);
    const LatticeElasticity elasticity(scene);
    const Displacement u = random_field(scene, 1), v = random_field(scene, 2),
                       diagonal = elasticity.diagonal();
    Displacement of_u(scene.specimen.grid), of_v(of_u);
    ThreadTeam team(1);
    elasticity.apply(u, of_u, team);
    elasticity.apply(v, of_v, team);
    EXPECT_NEAR(test::product(v, of_u), test::product(u, of_v), 1e-12 * std::abs(test::product(u, of_u)));
    for (std::size_t i = 0; i < diagonal.values().size(); ++i) {
      Displacement unit(scene.specimen.grid);
      unit.values()[i] = 1;
      elasticity.apply(unit, of_u, team);
      EXPECT_NEAR(diagonal.values()[i], of_u.values()[i], 1e-12 * of_u.values()[i]);
    }
  }
}

TEST(LatticeElasticityAnalytic, RigidMotionsAreAllThatCostsNothing) {
  for (const int dimension : {2, 3}) {
    Scene scene = test::box_scene(dimension, {2, 2, dimension > 2 ? 2 : 1});
    scene.materials[0].elasticity = ElasticConstants::isotropic(10e3, 0.4);
    const LatticeElasticity elasticity(scene);
    const auto n = static_cast<Eigen::Index>(scene.specimen.grid.n_nodes());
    Eigen::MatrixXd K(dimension * n, dimension * n);
    ThreadTeam team(1);
    for (Eigen::Index column = 0; column < K.cols(); ++column) {
      Displacement unit(scene.specimen.grid), forces(scene.specimen.grid);
      unit(column / n, column % n) = 1;
      elasticity.apply(unit, forces, team);
      for (Eigen::Index row = 0; row < K.rows(); ++row)
        K(row, column) = forces(row / n, row % n);
    }
    const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(K).eigenvalues();
    const int rigid = dimension == 2 ? 3 : 6; // shifts and turns
    EXPECT_LE(std::abs(values[rigid - 1]), 1e-12 * values[values.size() - 1]);
    EXPECT_GE(values[rigid], 1e-4 * values[values.size() - 1]);
  }
}

/// Forces at the corners (two a corner) of a rectangle by assumed stresses: constant, xx linear across x, yy
/// linear across y.
/// Source  Pian and Sumihara 1984, Int. J. Numer. Methods Eng. 20: their element on a rectangle
Eigen::Matrix<double, 8, 8> stiffness_by_assumed_stress(const Eigen::Matrix3d& C, double hx, double hy) {
  Eigen::Matrix<double, 5, 5> flexibility = Eigen::Matrix<double, 5, 5>::Zero();
  Eigen::Matrix<double, 5, 8> work = Eigen::Matrix<double, 5, 8>::Zero();
  const double point = std::sqrt(1.0 / 3);
  for (const double x : {-point, point})
    for (const double y : {-point, point}) {
      Eigen::Matrix<double, 3, 5> stress;
      stress << 1, 0, 0, y, 0, 0, 1, 0, 0, x, 0, 0, 1, 0, 0;
      Eigen::Matrix<double, 3, 8> strain = Eigen::Matrix<double, 3, 8>::Zero();
      for (int corner = 0; corner < 4; ++corner) {
        const double sx = corner & 1 ? 1 : -1, sy = corner & 2 ? 1 : -1;
        const double dx = sx * (1 + sy * y) / 2 / hx, dy = sy * (1 + sx * x) / 2 / hy;
        strain(0, 2 * corner) = strain(2, 2 * corner + 1) = dx;
        strain(1, 2 * corner + 1) = strain(2, 2 * corner) = dy;
      }
      flexibility += hx * hy / 4 * stress.transpose() * C.inverse() * stress;
      work += hx * hy / 4 * stress.transpose() * strain;
    }
  return work.transpose() * flexibility.inverse() * work;
}

// Truth: an element that knows nothing of links. In 2D the two are one and the same, however the fibres run.
TEST(LatticeElasticityAnalytic, InThePlaneItIsTheElementOfAssumedStresses) {
  for (const double degrees : {0.0, 20.0, 45.0, 70.0}) {
    Scene scene = test::box_scene(2, {1, 1, 1}, {1e-3, 0.7e-3, 1});
    scene.materials[0].elasticity = // E_fibre / E_cross 506, as of a tendon
        ElasticConstants::transversely_isotropic(157e6, 0.31e6, 0.104e6, 0.49, 0.49);
    scene.specimen.fibre = {std::cos(degrees * std::numbers::pi / 180),
                            std::sin(degrees * std::numbers::pi / 180), 0};
    const LatticeElasticity lattice(scene);
    const Eigen::Matrix<double, 8, 8> K = stiffness_by_assumed_stress(scene.cell_stiffness(0), 1e-3, 0.7e-3);
    for (int i = 0; i < 8; ++i) {
      Eigen::Matrix<double, 3, 4> u = Eigen::Matrix<double, 3, 4>::Zero();
      u(i % 2, i / 2) = 1;
      const Eigen::Matrix<double, 3, 4> force = lattice.cell_forces<2>(0, u);
      for (int j = 0; j < 8; ++j)
        EXPECT_NEAR(force(j % 2, j / 2), K(j, i), 1e-9 * K.cwiseAbs().maxCoeff()) << degrees << " " << i << j;
    }
  }
}

TEST(LatticeElasticityContract, AnyNumberOfThreadsGivesTheSameBits) {
  const Scene scene = odd_body(3, 5);
  const LatticeElasticity elasticity(scene);
  const Displacement u = random_field(scene, 9);
  Displacement one(scene.specimen.grid), several(scene.specimen.grid);
  ThreadTeam alone(1);
  elasticity.apply(u, one, alone);
  for (const int threads : {2, 3, 7}) {
    ThreadTeam team(threads);
    elasticity.apply(u, several, team);
    EXPECT_EQ(one, several) << threads;
  }
}

} // namespace
} // namespace maille::deform
