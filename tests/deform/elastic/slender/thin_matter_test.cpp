/// Matter one or two cells thick: bent as plates are, by the closed formulae of plates.

#include "elastic/krylov/coupled_task.hpp"
#include "elastic/model/lattice_elasticity.hpp"
#include "elastic/model/thin_cells.hpp"
#include "maille/deform/solve.hpp"
#include "support/bodies/scenes.hpp"
#include "support/fields.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <cmath>

namespace maille::deform {
namespace {

double energy_of(const Scene& scene, const Displacement& u) {
  Displacement forces(scene.specimen.grid);
  ThreadTeam team(1);
  LatticeElasticity(scene).apply(u, forces, team);
  return 0.5 * test::product(u, forces);
}

/// A sheet across an axis, of matter without symmetry to the grid in its plane.
Scene sheet(int across, int thickness) {
  Index3 cells{5, 6, 4};
  cells[static_cast<std::size_t>(across)] = thickness;
  Scene scene = test::box_scene(3, cells, {1e-3, 1.2e-3, 0.9e-3});
  scene.materials[0].elasticity = ElasticConstants::transversely_isotropic(60e3, 10e3, 7e3, 0.3, 0.4);
  scene.specimen.fibre = {0.6, 0.8, 0};
  std::rotate(scene.specimen.fibre.begin(), scene.specimen.fibre.begin() + 2 - across,
              scene.specimen.fibre.end());
  return scene;
}

/// Kirchhoff's plate: energy area t^3 / 24 k . Q k, Q the stiffness in plane stress, k the curvatures.
TEST(ThinMatterAnalytic, SheetsOfOneAndTwoCellsBendAsPlates) {
  for (const int across : {0, 1, 2})
    for (const int thickness : {1, 2})
      for (const Eigen::Vector3d& k : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0),
                                       Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(1, -0.4, 0.7)}) {
        const Scene scene = sheet(across, thickness);
        const Grid& grid = scene.specimen.grid;
        const int a = (across + 1) % 3, b = (across + 2) % 3;
        const auto of = [](int axis) { return static_cast<std::size_t>(axis); };
        const double t = thickness * grid.spacing()[of(across)];
        const Eigen::MatrixXd S = scene.cell_stiffness(0).inverse();
        const std::array<int, 3> rows{a, b, 3 + across};
        const Eigen::Matrix3d Q = Eigen::Matrix3d(S(rows, rows)).inverse();
        // Strains in the plane z k let what lies across give way by z S_c Q k, so its sides move by z^2 / 2
        // of that: nodes at the middle of two cells and at their sides tell of it.
        const double give = (S(across, rows) * Q * k).value();
        Displacement u(grid);
        double area = 1;
        for (const int axis : {a, b})
          area *= grid.cells()[of(axis)] * grid.spacing()[of(axis)];
        for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
          const Vec3 x = scene.specimen.position(grid.node_at(node));
          const double p = x[of(a)], q = x[of(b)], z = x[of(across)] - t / 2;
          u(a, node) = z * (k[0] * p + k[2] / 2 * q);
          u(b, node) = z * (k[1] * q + k[2] / 2 * p);
          u(across, node) = -(k[0] * p * p + k[1] * q * q + k[2] * p * q) / 2 + z * z / 2 * give;
        }
        const double expected = area * std::pow(t, 3) / 24 * k.dot(Q * k);
        EXPECT_NEAR(energy_of(scene, u), expected, 1e-10 * expected)
            << across << ' ' << thickness << " curvatures " << k.transpose();
      }
}

TEST(ThinMatterAnalytic, EvenStrainsCostWhatTheyDoInAnyBody) {
  const Scene scene = sheet(1, 1);
  const Grid& grid = scene.specimen.grid;
  Eigen::Matrix3d gradient;
  gradient << 0.3, -0.2, 0.5, 0.1, -0.4, 0.2, -0.6, 0.7, 0.25;
  Displacement u(grid);
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    const Vec3 x = scene.specimen.position(grid.node_at(node));
    for (int b = 0; b < 3; ++b)
      u(b, node) = gradient.row(b).dot(Eigen::Vector3d::Map(x.data()));
  }
  const Eigen::Matrix3d e = gradient + gradient.transpose();
  Eigen::Matrix<double, 6, 1> strain;
  strain << e(0, 0) / 2, e(1, 1) / 2, e(2, 2) / 2, e(1, 2), e(0, 2), e(0, 1);
  const double volume = static_cast<double>(grid.n_cells()) * 1e-3 * 1.2e-3 * 0.9e-3,
               expected = volume / 2 * strain.dot(scene.object_stiffness(0) * strain);
  EXPECT_NEAR(energy_of(scene, u), expected, 1e-12 * expected);
  for (int axis = 0; axis < 3; ++axis) {
    Displacement turned(grid);
    const int next = (axis + 1) % 3, last = (axis + 2) % 3;
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
      const Vec3 x = scene.specimen.position(grid.node_at(node));
      turned(next, node) = -x[static_cast<std::size_t>(last)];
      turned(last, node) = x[static_cast<std::size_t>(next)];
    }
    EXPECT_NEAR(energy_of(scene, turned), 0, 1e-12 * expected) << axis;
  }
}

TEST(ThinMatterAnalytic, RowsOfOneAndTwoCellsAreThin) {
  Scene scene = test::box_scene(3, {4, 3, 5});
  Specimen& body = scene.specimen;
  EXPECT_EQ(thin_axes(body, {1, 1, 1}), 0);
  EXPECT_FALSE(is_thin_box(body.grid.cells()));
  body.material_id.assign(60, 0);
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 4; ++x)
      body.material_id[static_cast<std::size_t>(body.grid.cell({x, y, 1}))] = no_material;
  EXPECT_EQ(thin_axes(body, {2, 1, 0}), 4) << "one cell below the gap";
  EXPECT_EQ(thin_axes(body, {2, 1, 3}), 0) << "three above it";
  body.material_id[static_cast<std::size_t>(body.grid.cell({2, 1, 4}))] = no_material;
  EXPECT_EQ(thin_axes(body, {2, 1, 3}), 4);
  EXPECT_EQ(thin_axes(body, {2, 2, 4}), 2) << "one beside it along y";
  EXPECT_EQ(thin_axes(body, {0, 1, 4}), 1) << "two along x";
  EXPECT_TRUE(is_thin_box({9, 2, 9}));
  EXPECT_EQ(thin_axes(test::box_scene(2, {4, 1, 1}).specimen, {0, 0, 0}), 0);
}

/// A strip whose sides may not move along y, bent by its weight: w = q L^4 / 8 D and by shear q L^2 / 2 G t.
TEST(ThinMatterAnalytic, APlateInPlaneStrainHangsAsFarAsItShould) {
  for (const int thickness : {1, 2})
    for (const double poisson : {0.3, 0.45, 0.49}) {
      const int length = 32;
      Scene scene = test::box_scene(3, {length, 3, thickness});
      scene.materials[0].elasticity = ElasticConstants::isotropic(1e6, poisson);
      scene.materials[0].density = 1000;
      scene.gravity = {0, 0, -0.981};
      scene.relaxation.tolerance = 1e-6;
      test::hold_face(scene, 0, false);
      for (const bool upper : {false, true})
        test::prescribe_face(scene, 1, upper, 1, 0, true);
      std::ranges::sort(scene.prescribed, {},
                        [](const Prescribed& p) { return std::pair(p.component, p.node); });
      const auto same = std::ranges::unique(
          scene.prescribed, {}, [](const Prescribed& p) { return std::pair(p.component, p.node); });
      scene.prescribed.erase(same.begin(), same.end());
      const Answer answer = solve(scene, Method::coupled);
      ASSERT_EQ(answer.status, Status::done) << answer.message;
      const double t = thickness * 1e-3, L = length * 1e-3, q = 1000 * 0.981 * t,
                   D = 1e6 * std::pow(t, 3) / 12 / (1 - poisson * poisson), G = 1e6 / 2 / (1 + poisson),
                   expected = q * std::pow(L, 4) / 8 / D + q * L * L / 2 / G / t;
      const double tip = -answer.displacement(2, scene.specimen.grid.node({length, 1, 0}));
      // The held end keeps a plate from narrowing across, too, over a thickness or so.
      EXPECT_NEAR(tip, expected, 0.03 * expected) << thickness << ' ' << poisson;
    }
}

} // namespace
} // namespace maille::deform
