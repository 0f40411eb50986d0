#include "rivals/lattice_rivals.hpp"

#include "maille/scene/answer.hpp"
#include "rivals/spring_lattice.hpp"
#include "support/bodies/scenes.hpp"
#include "support/fields.hpp"
#include "support/kit.hpp"

namespace maille::lab {
namespace {

using test::box_scene;

void give_poisson_ratio(Scene& scene, double nu) {
  for (Material& material : scene.materials)
    material.elasticity = ElasticConstants::isotropic(material.elasticity.youngs_modulus[0], nu);
}

/// A cube of n cells a side, held below; the middle fifth of its top moved up by `cells` spacings.
Scene poked_cube(int n, double cells) {
  Scene scene = box_scene(3, {n, n, n});
  test::hold_face(scene, 2, false);
  const Grid& grid = scene.specimen.grid;
  for (int y = 2 * n / 5; y <= 3 * n / 5; ++y)
    for (int x = 2 * n / 5; x <= 3 * n / 5; ++x)
      for (int b = 0; b < 3; ++b)
        scene.prescribed.push_back({grid.node({x, y, n}), b, b == 2 ? cells * 1e-3 : 0.0, false});
  test::sort_prescribed(scene);
  return scene;
}

/// A bar along x on frictionless supports below and behind, its left end kept from moving along.
Scene supported_bar() {
  Scene scene = box_scene(3, {8, 3, 2});
  for (int axis = 0; axis < 3; ++axis)
    test::prescribe_face(scene, axis, false, axis, 0, true);
  return scene;
}

// Truth: energy of an isotropic solid with the Poisson ratio that springs have. Springs that turn differ by
// the strain, 1e-6; stiffness is kept in float32.
TEST(SpringLatticeAnalytic, UniformStrainsStoreTheEnergyOfTheSolid) {
  const std::array<Vec3, 3> gradient{
      {{1e-6, 0.4e-6, -0.7e-6}, {-1.1e-6, -0.5e-6, 0.3e-6}, {0.2e-6, 0.9e-6, 0.8e-6}}};
  for (const int dimension : {1, 2, 3})
    for (const auto plane : {PlaneAssumption::strain, PlaneAssumption::stress})
      for (const Vec3& spacing : {Vec3{1e-3, 1e-3, 1e-3}, Vec3{1e-3, 1.1e-3, 0.95e-3}}) {
        Index3 cells{3, 1, 1};
        for (int a = 1; a < dimension; ++a)
          cells[static_cast<std::size_t>(a)] = 3 - a;
        Scene scene = box_scene(dimension, cells, spacing);
        scene.plane = plane;
        const bool is_stress = dimension == 2 && plane == PlaneAssumption::stress;
        give_poisson_ratio(scene, is_stress ? 1.0 / 3 : 1.0 / 4);
        const SpringLattice lattice(scene);
        ASSERT_EQ(lattice.refusal(), "");
        EXPECT_EQ(dimension == 1 ? "" : lattice.note(), "");

        const auto& g = gradient;
        Eigen::VectorXd strain(dimension * (dimension + 1) / 2);
        if (dimension == 1)
          strain << g[0][0];
        else if (dimension == 2)
          strain << g[0][0], g[1][1], g[0][1] + g[1][0];
        else
          strain << g[0][0], g[1][1], g[2][2], g[1][2] + g[2][1], g[0][2] + g[2][0], g[0][1] + g[1][0];
        double volume = static_cast<double>(scene.specimen.grid.n_cells());
        for (int a = 0; a < dimension; ++a)
          volume *= scene.specimen.grid.spacing()[static_cast<std::size_t>(a)];
        const double expected = 0.5 * volume * strain.dot(scene.cell_stiffness(0) * strain);
        const auto u = test::affine_displacement<Displacement>(scene, gradient);
        EXPECT_NEAR(lattice.strain_energy(u), expected, 1e-5 * expected) << dimension << "D";
      }
}

TEST(SpringLatticeContract, WhatItCannotBeIsSaid) {
  EXPECT_NE(SpringLattice(box_scene(3, {2, 2, 2})).note().find("Poisson ratio 0.25; soft has 0.3"),
            std::string::npos);
  Scene oblong = box_scene(3, {2, 2, 2}, {3e-3, 1e-3, 1e-3});
  EXPECT_NE(SpringLattice(oblong).refusal(), "");
}

/// False, and says so, where there is no libbullet.
bool has_bullet() {
  return relax_by_bullet(poked_cube(2, 0.2), 0.0).has_value();
}

// Truth: symmetry. Bullet's rest state leans the way in which links are solved, each after its predecessors
// were: 3 % here.
TEST(BulletAnalytic, TheMiddleOfAStretchedBarMovesHalfAsFarAsItsEnd) {
  if (!has_bullet())
    GTEST_SKIP() << "there was no libbullet to build with";
  Scene scene = box_scene(3, {8, 2, 2});
  test::hold_face(scene, 0, false);
  test::move_face(scene, 0, true, {0.4e-3, 0, 0});
  const RivalResult result = *relax_by_bullet(scene, 0.3);
  double mean = 0;
  for (int z = 0; z <= 2; ++z)
    for (int y = 0; y <= 2; ++y)
      mean += result.displacement(0, scene.specimen.grid.node({4, y, z})) / 9;
  EXPECT_NEAR(mean, 0.2e-3, 0.1 * 0.2e-3);
}

TEST(BulletContract, PrescribedNodesAreWhereTheyWereAskedAndTheBudgetIsKept) {
  if (!has_bullet())
    GTEST_SKIP() << "there was no libbullet to build with";
  const Scene scene = poked_cube(7, 0.3);
  const RivalResult result = *relax_by_bullet(scene, 0.1);
  for (const Prescribed& p : scene.prescribed) // positions, not displacements, are in float32
    EXPECT_NEAR(result.displacement(p.component, p.node), p.value, 2e-6 * 1e-3);
  EXPECT_GT(result.iterations, 1);
  EXPECT_GE(result.seconds, 0.1);
  EXPECT_LT(result.seconds, 1.0); // a step takes less than ten milliseconds; the machine may be busy
}

TEST(BulletContract, WhatItCannotCarryIsSaid) {
  if (!has_bullet())
    GTEST_SKIP() << "there was no libbullet to build with";
  Scene heavy = poked_cube(3, 0.2);
  heavy.gravity = {0, 0, -9.81};
  for (const Scene& scene : {heavy, supported_bar()}) {
    const RivalResult result = *relax_by_bullet(scene, 0.01);
    EXPECT_TRUE(result.displacement.empty());
    EXPECT_NE(result.note, "");
  }
}

} // namespace
} // namespace maille::lab
