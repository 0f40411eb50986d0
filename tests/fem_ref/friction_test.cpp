/// Coulomb's friction of sliding borders in finite elements, against closed forms.

#include "fem_ref/bodies.hpp"
#include "support/bodies/layers.hpp"
#include "support/kit.hpp"

namespace maille::fem_ref {
namespace {

constexpr double h = 1e-3, E = 100e3, mu = 0.3;

using test::force_of_moves;

SceneBuilder layers(const Index3& cells, const ElasticConstants& below, const ElasticConstants& above) {
  return test::layers(cells, h, below, above);
}

// Truth: Coulomb. Where all of a border slips one way, what is drawn is mu times what presses.
TEST(FemFrictionAnalytic, ABlockThatIsDrawnFarTransmitsMuTimesWhatPressesIt) {
  const ElasticConstants matter = ElasticConstants::isotropic(E, 0);
  Scene scene = layers({3, 3, 6}, matter, matter).move("z+", {1e-3, 0, -2e-4}, "xyz").build();
  scene.relaxation.tolerance = 1e-6;
  scene.sliding = {{1, 2, mu}};
  const Answer answer = test::solved(scene, {}).answer;
  const double drawn = force_of_moves(scene, answer, 0), pressed = -force_of_moves(scene, answer, 2);
  EXPECT_NEAR(pressed, E * 2e-4 / (6 * h) * 9 * h * h, 1e-6 * pressed);
  EXPECT_EQ(answer.rubbing.at(0).slipping, 1);
  EXPECT_NEAR(answer.rubbing.at(0).pressed, pressed, 1e-4 * pressed);
  EXPECT_NEAR(drawn, mu * pressed, 1e-4 * pressed);
}

// Truth: statics. Under forces alone a block stays while it is drawn with less than mu times what presses
// it, and then all of that force goes through the border; with more nothing holds it.
TEST(FemFrictionAnalytic, ForcesBelowMuTimesThePressureHoldABlock) {
  constexpr double p = 2e3, area = 9 * h * h;
  const ElasticConstants matter = ElasticConstants::isotropic(E, 0);
  for (const double share : {0.6, 1.1}) {
    Scene scene = layers({3, 3, 6}, matter, matter).build();
    for (int y = 0; y < 3; ++y)
      for (int x = 0; x < 3; ++x)
        scene.tractions.push_back({scene.specimen.grid.cell({x, y, 5}), 2, true, {0, 0, -p}});
    for (int y = 0; y < 3; ++y) // drawn just above the border, so that it tilts little
      scene.tractions.push_back({scene.specimen.grid.cell({2, y, 3}), 0, true, {3 * share * mu * p, 0, 0}});
    scene.sliding = {{1, 2, mu}};
    const Answer answer = solve(scene, Options{}).answer;
    if (share > 1) {
      EXPECT_EQ(answer.status, Status::failed);
      EXPECT_TRUE(test::has(answer.message, "label 2 (27 cells) can still move along x"));
      continue;
    }
    ASSERT_EQ(answer.status, Status::done) << answer.message;
    double held = 0;
    for (std::size_t i = 0; i < answer.reaction.size(); ++i)
      held -= scene.prescribed[i].component == 0 ? answer.reaction[i] : 0;
    EXPECT_NEAR(held, share * mu * p * area, 1e-6 * mu * p * area);
    EXPECT_NEAR(answer.rubbing.at(0).pressed, p * area, 1e-3 * p * area);
    EXPECT_LE(answer.rubbing.at(0).rubbed, mu * p * area * (1 + 1e-3));
  }
}

// Truth: a bar on a rough bed that is drawn at one end with T = q h (m + 1/2), q = mu p times its width,
// slips over the nodes within reach and moves there by q h^2 m (m + 1) / (2 E A).
TEST(FemFrictionAnalytic, ABarOnARoughBedSlipsAsFarAsItsPullReaches) {
  Scene scene;
  const double moved = test::draw_on_rough_bed(h, E, scene)[0];
  scene.relaxation.tolerance = 1e-6;
  const Answer answer = test::solved(scene, {}).answer;
  const double end = answer.displacement(0, scene.specimen.grid.node({16, 0, 2}));
  EXPECT_NEAR(end, moved, 3e-3 * end);
}

TEST(FemFrictionContract, QuadraticElementsRefuseItInWords) {
  const ElasticConstants matter = ElasticConstants::isotropic(E, 0);
  Scene scene = layers({2, 2, 2}, matter, matter).move("z+", {1e-4, 0, -1e-4}, "xyz").build();
  scene.sliding = {{1, 2, mu}};
  Options options;
  options.degree = 2;
  const Answer answer = solve(scene, options).answer;
  EXPECT_EQ(answer.status, Status::refused);
  EXPECT_TRUE(test::has(answer.message, "friction"));
}

/// Forces that keep a body in place, and the energy in it.

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
