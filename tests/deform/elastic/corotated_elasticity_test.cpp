#include "elastic/corotated/corotated_elasticity.hpp"

#include "maille/scene/block_frames.hpp"
#include "support/bodies/bent_bar.hpp"
#include "support/fields.hpp"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <random>

namespace maille::deform {
namespace {

double uniform(std::mt19937& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random()) / static_cast<double>(std::mt19937::max());
}

/// Turned fibres, a hole, oblong cells.
Scene odd_body(int dimension) {
  Scene scene =
      test::box_scene(dimension, {3, 3, dimension == 3 ? 2 : 1}, {1e-3, 1.4e-3, dimension == 3 ? 0.7e-3 : 1});
  scene.materials[0].elasticity = ElasticConstants::transversely_isotropic(60e3, 10e3, 7e3, 0.3, 0.4);
  scene.specimen.fibre = {0.8, 0.6, 0};
  scene.specimen.material_id.assign(static_cast<std::size_t>(scene.specimen.grid.n_cells()), 0);
  scene.specimen.material_id[4] = no_material;
  return scene;
}

/// A turn of everything, and large uneven strains.
Displacement turned_and_strained(const Scene& scene, double angle, double strain, unsigned seed) {
  std::mt19937 random(seed);
  Turn turn;
  turn.angle = angle;
  turn.axis = scene.dimension() == 3 ? Vec3{2.0 / 3, -1.0 / 3, 2.0 / 3} : Vec3{0, 0, 1};
  turn.by = {0.3, -0.2, 0.1};
  const Grid& grid = scene.specimen.grid;
  Displacement u(grid);
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    Vec3 x = scene.specimen.position(grid.node_at(node)), w{};
    for (std::size_t b = 0; b < static_cast<std::size_t>(scene.dimension()); ++b) {
      w[b] = strain * grid.spacing()[b] * uniform(random, -1, 1);
      x[b] += w[b];
    }
    const Vec3 turned = turn.displacement(x);
    for (int b = 0; b < scene.dimension(); ++b)
      u(b, node) = w[static_cast<std::size_t>(b)] + turned[static_cast<std::size_t>(b)];
  }
  return u;
}

class EveryDimension : public testing::TestWithParam<int> {};
using CorotatedElasticityAnalytic = EveryDimension;
using CorotatedElasticityOracle = EveryDimension;
INSTANTIATE_TEST_SUITE_P(Dimensions, CorotatedElasticityAnalytic, testing::Values(2, 3));
INSTANTIATE_TEST_SUITE_P(Dimensions, CorotatedElasticityOracle, testing::Values(2, 3));

// Truth: a frame that turns with the body sees nothing of its turn.
TEST_P(CorotatedElasticityAnalytic, ATurnChangesNoEnergyAndTurnsTheForces) {
  const Scene scene = odd_body(GetParam());
  const LatticeElasticity linear(scene);
  ThreadTeam team(1);
  Displacement forces(scene.specimen.grid), turned_forces(forces);
  CorotatedElasticity elasticity(scene, linear);
  const double energy = elasticity.evaluate(turned_and_strained(scene, 0, 0.2, 7), forces, team);
  for (const double angle : {0.3, 1.7, 3.1, -2.5}) {
    CorotatedElasticity other(scene, linear);
    EXPECT_NEAR(other.evaluate(turned_and_strained(scene, angle, 0.2, 7), turned_forces, team), energy,
                1e-11 * energy); // 0.3 m away from rest, in cells of a millimetre
    Turn turn{{0, 0, 1}, angle, {}, {}, {true, true, true}, {}};
    if (GetParam() == 3)
      turn.axis = {2.0 / 3, -1.0 / 3, 2.0 / 3};
    for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node) {
      Vec3 force{};
      for (int b = 0; b < GetParam(); ++b)
        force[static_cast<std::size_t>(b)] = forces(b, node);
      const Vec3 change = turn.displacement(force);
      for (int b = 0; b < GetParam(); ++b)
        EXPECT_NEAR(turned_forces(b, node),
                    force[static_cast<std::size_t>(b)] + change[static_cast<std::size_t>(b)],
                    1e-9 * 10e3 * 1e-6);
    }
    EXPECT_NEAR(other.evaluate(turned_and_strained(scene, angle, 0, 7), turned_forces, team), 0,
                1e-18 * 10e3);
  }
}

// Truth: differences of the energy itself.
TEST_P(CorotatedElasticityOracle, ForcesAreTheGradientOfTheEnergy) {
  const Scene scene = odd_body(GetParam());
  const LatticeElasticity linear(scene);
  ThreadTeam team(1);
  CorotatedElasticity elasticity(scene, linear);
  Displacement forces(scene.specimen.grid), unused(forces);
  Displacement u = turned_and_strained(scene, 1.1, 0.3, 3);
  elasticity.evaluate(u, forces, team);
  const double largest = test::largest(forces);
  for (int b = 0; b < GetParam(); ++b)
    for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node) {
      const double there = u(b, node), step = 1e-8;
      u(b, node) = there + step;
      const double above = elasticity.evaluate(u, unused, team);
      u(b, node) = there - step;
      const double below = elasticity.evaluate(u, unused, team);
      u(b, node) = there;
      EXPECT_NEAR(forces(b, node), (above - below) / (2 * step), 1e-6 * largest) << b << ' ' << node;
    }
}

// Truth: LatticeElasticity, of which this is the same for small displacements.
TEST_P(CorotatedElasticityOracle, SmallDisplacementsCostWhatTheyCostInCoupled) {
  const Scene scene = odd_body(GetParam());
  const LatticeElasticity linear(scene);
  ThreadTeam team(1);
  Displacement forces(scene.specimen.grid), of_linear(forces);
  double last = 0;
  for (const double size : {1e-2, 1e-3, 1e-4}) {
    const Displacement u = turned_and_strained(scene, 0, size, 11);
    Displacement small = u;
    for (int b = 0; b < GetParam(); ++b) { // without the shift of turned_and_strained
      const double shift = small(b, 0);
      for (double& value : small.component(b))
        value -= shift;
    }
    CorotatedElasticity elasticity(scene, linear);
    elasticity.evaluate(small, forces, team);
    linear.apply(small, of_linear, team);
    const double difference = test::relative_difference(forces, of_linear);
    EXPECT_LT(difference, 3 * size); // relative to the force: second order
    if (last > 0) {
      EXPECT_NEAR(last / difference, 10, 1);
    }
    last = difference;
  }
}

// Truth: the definition, by singular values.
TEST(NearestRotationOracle, MakesTheStretchSymmetricAndTheDistanceLeast) {
  std::mt19937 random(5);
  for (int i = 0; i < 200; ++i) {
    Eigen::Matrix3d F;
    for (Eigen::Index k = 0; k < 9; ++k)
      F(k) = uniform(random, -1, 1);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> squares(F.transpose() * F);
    const Eigen::Vector3d values = squares.eigenvalues().cwiseMax(0).cwiseSqrt(); // ascending
    const double most = values[2] + values[1] + (F.determinant() < 0 ? -values[0] : values[0]);
    const Eigen::Quaterniond guess =
        Eigen::Quaterniond(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1), 0.1)
            .normalized();
    const Eigen::Matrix3d R = nearest_rotation(3, F, guess).toRotationMatrix();
    EXPECT_NEAR((R.transpose() * F).trace(), most, 1e-12); // nearest: the largest trace
  }
}

} // namespace
} // namespace maille::deform
