#include "maille/scene/cell_fields.hpp"

#include "support/bodies/scenes.hpp"

#include <gtest/gtest.h>

namespace maille {
namespace {

constexpr double E = 10e3, nu = 0.3; // of test::box_scene

CellFields fields_of(const Scene& scene, const std::array<Vec3, 3>& gradient) {
  return cell_fields(scene, test::affine_displacement<Displacement>(scene, gradient));
}

TEST(CellFieldsAnalytic, PatchOfMacNealAndHarder) {
  // MacNeal, Harder 1985: u = 1e-3 (2x+y+z)/2 and cyclic, E = 1e6, nu = 0.25: normal stresses 2000,
  // shear 400.
  Scene scene = test::box_scene(3, {2, 2, 2});
  scene.materials[0].elasticity = ElasticConstants::isotropic(1e6, 0.25);
  const CellFields fields = fields_of(scene, {{{1e-3, 5e-4, 5e-4}, {5e-4, 1e-3, 5e-4}, {5e-4, 5e-4, 1e-3}}});
  for (std::size_t cell = 0; cell < 8; ++cell) {
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(fields.strain[cell][i], 1e-3, 1e-15);
      EXPECT_NEAR(fields.strain[cell][i + 3], 5e-4, 1e-15);
      EXPECT_NEAR(fields.stress[cell][i], 2000, 1e-9);
      EXPECT_NEAR(fields.stress[cell][i + 3], 400, 1e-9);
    }
    EXPECT_NEAR(fields.von_mises[cell], 400 * 3, 1e-9); // sqrt(3 * 3 * 400^2)
  }
}

TEST(CellFieldsAnalytic, ShearComponentsStandInVtkOrder) {
  const Scene scene = test::box_scene(3, {1, 1, 1});
  const double G = E / (2 * (1 + nu));
  // gamma of xy, yz, xz in turn; VTK's order is XX YY ZZ XY YZ XZ.
  EXPECT_NEAR(fields_of(scene, {{{0, 1e-3, 0}, {}, {}}}).stress[0][3], G * 1e-3, 1e-9);
  EXPECT_NEAR(fields_of(scene, {{{}, {0, 0, 1e-3}, {}}}).stress[0][4], G * 1e-3, 1e-9);
  EXPECT_NEAR(fields_of(scene, {{{0, 0, 1e-3}, {}, {}}}).stress[0][5], G * 1e-3, 1e-9);
}

TEST(CellFieldsAnalytic, BarIsUniaxialAndContractsFreely) {
  const CellFields fields = fields_of(test::box_scene(1, {4, 1, 1}), {{{0.01, 0, 0}, {}, {}}});
  EXPECT_NEAR(fields.stress[0][0], E * 0.01, 1e-9);
  EXPECT_NEAR(fields.stress[0][1], 0, 1e-9);
  EXPECT_NEAR(fields.strain[0][2], -nu * 0.01, 1e-15);
}

TEST(CellFieldsAnalytic, PlaneStressAndPlaneStrainDifferOutOfThePlane) {
  Scene scene = test::box_scene(2, {2, 2, 1});
  const std::array<Vec3, 3> stretch{{{0.01, 0, 0}, {}, {}}};
  const CellFields strain = fields_of(scene, stretch);
  const double lambda = E * nu / ((1 + nu) * (1 - 2 * nu));
  EXPECT_NEAR(strain.stress[0][2], lambda * 0.01, 1e-9);
  EXPECT_EQ(strain.strain[0][2], 0);
  scene.plane = PlaneAssumption::stress;
  const CellFields stress = fields_of(scene, stretch);
  EXPECT_NEAR(stress.stress[0][0], E / (1 - nu * nu) * 0.01, 1e-9);
  EXPECT_NEAR(stress.stress[0][2], 0, 1e-9);
  EXPECT_NEAR(stress.strain[0][2], -nu / (1 - nu) * 0.01, 1e-15);
}

TEST(CellFieldsAnalytic, CellsWithoutMatterStayZero) {
  Scene scene = test::box_scene(2, {2, 1, 1});
  scene.specimen.material_id = {0, no_material};
  const CellFields fields = fields_of(scene, {{{0.01, 0, 0}, {}, {}}});
  EXPECT_GT(fields.von_mises[0], 0);
  EXPECT_EQ(fields.von_mises[1], 0);
}

} // namespace
} // namespace maille
