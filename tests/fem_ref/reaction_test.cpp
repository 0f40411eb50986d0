/// Forces that keep a body in place, and the energy in it, by finite elements.

#include "fem_ref/bodies.hpp"
#include "support/bodies/condition_bodies.hpp"
#include "support/bodies/layers.hpp"
#include "support/kit.hpp"

std::vector<maille::test::ConditionSolver> maille::test::condition_solvers() {
  const auto by = [](int degree) {
    return [=](const Scene& scene) {
      fem_ref::Options options;
      options.degree = degree;
      return fem_ref::solve(scene, options).answer;
    };
  };
  return {{.name = "fem_q1", .solve = by(1), .accuracy = 1e-6, .has_friction = true},
          {.name = "fem_q2", .solve = by(2), .accuracy = 1e-6}};
}

namespace maille::fem_ref {
namespace {

TEST(FemFrictionContract, QuadraticElementsRefuseItInWords) {
  Scene scene = test::alike_layers({2, 2, 2}, 1e-3, 100e3, 0).move("z+", {1e-4, 0, -1e-4}, "xyz").build();
  scene.sliding = {{1, 2, 0.3}};
  Options options;
  options.degree = 2;
  const Answer answer = solve(scene, options).answer;
  EXPECT_EQ(answer.status, Status::refused);
  EXPECT_TRUE(test::has(answer.message, "friction"));
}

using test::total_reaction;

Answer solved(const Scene& scene, int degree) {
  Options options;
  options.degree = degree;
  return test::solved(scene, options).answer;
}

/// Half of what the prescribed moves work.
double half_work(const Scene& scene, const Answer& answer) {
  double work = 0;
  for (std::size_t i = 0; i < scene.prescribed.size(); ++i)
    work += 0.5 * scene.prescribed[i].value * answer.reaction[i];
  return work;
}

class ReactionAnalytic : public testing::TestWithParam<std::tuple<int, int>> {};

TEST_P(ReactionAnalytic, ABarIsPulledByYoungsModulusTimesStrainTimesArea) {
  const auto [dimension, degree] = GetParam();
  Scene scene = test::box_scene(dimension, {6, dimension > 1 ? 3 : 1, dimension > 2 ? 2 : 1});
  scene.materials[0].elasticity =
      ElasticConstants::isotropic(10e3, 0); // no Poisson effect: the clamped ends do not matter
  test::hold_face(scene, 0, false);
  const Vec3& spacing = scene.specimen.grid.spacing();
  const double strain = 0.02, modulus = 10e3;
  test::move_face(scene, 0, true, {strain * 6 * spacing[0], 0, 0});
  double area = 1;
  if (dimension > 1)
    area *= 3 * spacing[1];
  if (dimension > 2)
    area *= 2 * spacing[2];
  const Answer answer = solved(scene, degree);
  const double force = modulus * strain * area; // Hooke
  EXPECT_NEAR(total_reaction(scene, answer, 0, false), force, 1e-9 * force);
  EXPECT_NEAR(total_reaction(scene, answer, 0, true), -force, 1e-9 * force);
  const double energy = 0.5 * modulus * strain * strain * area * 6 * spacing[0];
  EXPECT_NEAR(*answer.strain_energy, energy, 1e-9 * energy);
}

TEST_P(ReactionAnalytic, HoldsCarryTheLoadsAndMovesWorkTheEnergy) {
  const auto [dimension, degree] = GetParam();
  Scene scene = test::box_scene(dimension, {5, dimension > 1 ? 4 : 1, dimension > 2 ? 3 : 1});
  scene.materials[0].density = 1000;
  scene.materials[0].elasticity = ElasticConstants::transversely_isotropic(50e3, 10e3, 6e3, 0.3, 0.4);
  if (dimension > 1)
    scene.specimen.fibre = {0.8, 0.6, 0};
  test::hold_face(scene, 0, false);
  Scene moved = scene;
  test::move_face(moved, 0, true, {0.1e-3, dimension > 1 ? 0.05e-3 : 0.0, dimension > 2 ? -0.02e-3 : 0.0});
  const Answer of_moves = solved(moved, degree);
  for (int b = 0; b < dimension; ++b) { // equilibrium
    const double pull = total_reaction(moved, of_moves, b, false);
    EXPECT_NEAR(total_reaction(moved, of_moves, b, true), -pull,
                1e-8 * std::abs(total_reaction(moved, of_moves, 0, false)));
  }
  EXPECT_NEAR(*of_moves.strain_energy, half_work(moved, of_moves),
              1e-9 * *of_moves.strain_energy); // Clapeyron

  scene.gravity = {2, 0, 0};
  const Vec3& spacing = scene.specimen.grid.spacing();
  double volume = 1, n[3] = {5, 4, 3};
  for (int a = 0; a < dimension; ++a)
    volume *= n[a] * spacing[static_cast<std::size_t>(a)];
  const double weight = 1000 * 2 * volume;
  EXPECT_NEAR(total_reaction(scene, solved(scene, degree), 0, true), -weight, 1e-9 * weight);
}

INSTANTIATE_TEST_SUITE_P(OfEveryDimensionAndDegree, ReactionAnalytic,
                         testing::Combine(testing::Values(1, 2, 3), testing::Values(1, 2)),
                         [](const auto& of) {
                           return fmt::format("in_{}D_of_degree_{}", std::get<0>(of.param),
                                              std::get<1>(of.param));
                         });

} // namespace
} // namespace maille::fem_ref
