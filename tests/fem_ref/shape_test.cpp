// Cells that are bent into shape, and stress at nodes.
#include "fem_ref/bodies.hpp"

#include <gtest/gtest.h>

namespace maille {
namespace {

Scene slanted_box(int dimension) {
  Scene scene =
      test::box_scene(dimension, dimension == 2 ? Index3{5, 4, 1} : Index3{4, 3, 3}, {0.2, 0.25, 0.3});
  scene.materials = {test::material_of(test::fibrous())};
  scene.specimen.fibre = test::slanted_fibre(dimension);
  return scene;
}

Vec3 bent(const Vec3& x) {
  return {x[0] + 0.1 * x[0] * x[1], x[1] + 0.15 * x[0] * x[0], x[2] + 0.1 * x[0] * x[2]};
}

/// Any straight line stays straight: only shears and stretches.
Vec3 stretched(const Vec3& at) {
  return {1e-3 * at[0] + 2e-3 * at[1], -5e-4 * at[0] + 3e-3 * at[1] + 1e-3 * at[2],
          2e-3 * at[2] - 1e-3 * at[0]};
}

// Truth: a linear displacement has one strain, whatever the mesh (the patch test), and that strain its stress
// C : eps.
TEST(ShapeAnalytic, BentCellsHoldConstantStrain) {
  for (const int dimension : {2, 3})
    for (const int degree : {1, 2}) {
      const Scene scene = slanted_box(dimension);
      fem_ref::Options options = test::options_of(degree);
      options.shape = bent;
      options.recover_stress = true;
      options.boundary_displacement = [dimension](const Vec3& x) {
        Vec3 u = stretched(x);
        if (dimension == 2)
          u = stretched({x[0], x[1], 0});
        return u;
      };
      const Answer answer = fem_ref::solve(scene, options).answer;
      ASSERT_EQ(answer.status, Status::done) << answer.message;
      const Grid& grid = scene.specimen.grid;
      Eigen::VectorXd strain(dimension == 2 ? 3 : 6);
      if (dimension == 2)
        strain << 1e-3, 3e-3, 1.5e-3;
      else
        strain << 1e-3, 3e-3, 2e-3, 1e-3, -1e-3, 1.5e-3;
      const Eigen::VectorXd stress = scene.cell_stiffness(0) * strain;
      const double size = stress.cwiseAbs().maxCoeff();
      for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
        const Vec3 u = stretched(bent(scene.specimen.position(grid.node_at(node))));
        for (int c = 0; c < dimension; ++c)
          EXPECT_NEAR(answer.displacement(c, node), u[static_cast<std::size_t>(c)], 1e-13);
        const auto& found = answer.nodal_stress[static_cast<std::size_t>(node)];
        EXPECT_NEAR(answer.nodal_strain[static_cast<std::size_t>(node)][3], 0.75e-3, 1e-12);
        EXPECT_NEAR(found[0], stress[0], 1e-9 * size);
        EXPECT_NEAR(found[1], stress[1], 1e-9 * size);
        EXPECT_NEAR(found[3], stress[dimension == 2 ? 2 : 5], 1e-9 * size); // XY
      }
    }
}

// Truth: pure bending of an isotropic bar, a polynomial of degree two: stress E k z along the bar and nothing
// else. Quadratic elements hold it, so their strain is linear in every cell and its recovery exact, at the
// boundary too.
TEST(RecoveryAnalytic, BendingStressIsExactForQuadraticElements) {
  constexpr double E = 10e3, nu = 0.3, k = 0.01;
  Scene scene = test::box_scene(3, {4, 3, 4}, {0.2, 0.25, 0.3});
  scene.materials = {test::material_of(ElasticConstants::isotropic(E, nu))};
  fem_ref::Options options = test::options_of(2);
  options.recover_stress = true;
  options.boundary_displacement = [](const Vec3& x) {
    return Vec3{k * x[0] * x[2], -nu * k * x[1] * x[2],
                -k / 2 * (x[0] * x[0] + nu * (x[2] * x[2] - x[1] * x[1]))};
  };
  const Answer answer = fem_ref::solve(scene, options).answer;
  ASSERT_EQ(answer.status, Status::done) << answer.message;
  for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node) {
    const double z = scene.specimen.position(scene.specimen.grid.node_at(node))[2];
    const auto& stress = answer.nodal_stress[static_cast<std::size_t>(node)];
    EXPECT_NEAR(stress[0], E * k * z, 1e-9 * E * k);
    for (const std::size_t other : {1, 2, 3, 4, 5})
      EXPECT_NEAR(stress[other], 0, 1e-9 * E * k);
  }
}

// Truth: two bars in line carry one stress; each has its own strain. The nodes between them show the material
// of lower number.
TEST(RecoveryAnalytic, StressIsNotAveragedAcrossMaterials) {
  Scene scene = test::box_scene(1, {6, 1, 1}, {0.1, 1, 1});
  scene.materials = {test::material_of(ElasticConstants::isotropic(10e3, 0.3)),
                     test::material_of(ElasticConstants::isotropic(40e3, 0.3))};
  scene.specimen.material_id = {0, 0, 0, 1, 1, 1};
  test::hold_face(scene, 0, false);
  test::pull_face(scene, 0, true, {100, 0, 0});
  fem_ref::Options options = test::options_of(1);
  options.recover_stress = true;
  const Answer answer = fem_ref::solve(scene, options).answer;
  for (std::size_t node = 0; node < 7; ++node) {
    EXPECT_NEAR(answer.nodal_stress[node][0], 100, 1e-9);
    EXPECT_NEAR(answer.nodal_strain[node][0], node <= 3 ? 0.01 : 0.0025, 1e-12);
  }
}

TEST(ShapeContract, AShapeThatTurnsCellsInsideOutIsAFailure) {
  Scene scene = test::box_scene(2, {2, 2, 1});
  test::hold_face(scene, 0, false);
  fem_ref::Options options = test::options_of(1);
  options.shape = [](const Vec3& x) { return Vec3{-x[0], x[1], x[2]}; };
  const Answer answer = fem_ref::solve(scene, options).answer;
  EXPECT_EQ(answer.status, Status::failed);
  EXPECT_EQ(answer.message, "the shape turns a cell inside out");
}

} // namespace
} // namespace maille
