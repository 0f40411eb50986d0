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

} // namespace
} // namespace maille::lab
