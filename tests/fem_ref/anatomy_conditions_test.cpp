/// Springs to the ground, weights of cells and sliding borders in finite elements, against closed forms.

#include "fem_ref/bodies.hpp"
#include "maille/scene/scene_builder.hpp"
#include "support/bodies/layers.hpp"
#include "support/kit.hpp"

namespace maille::fem_ref {
namespace {

constexpr double h = 1e-3, E1 = 100e3, E2 = 40e3, nu1 = 0.3, nu2 = 0.45;

Answer answer_of(const Scene& scene, int degree) {
  Options options;
  options.degree = degree;
  return test::solved(scene, options).answer;
}

/// Labels 1 below, 2 above, pressed on top, each kept from moving sideways.
Scene two_blocks(double shift) {
  std::vector<std::uint8_t> labels(3 * 3 * 6, 1);
  std::fill(labels.begin() + 27, labels.end(), std::uint8_t{2});
  Scene scene = SceneBuilder("blocks")
                    .labels(std::span<const std::uint8_t>(labels), ArrayLayout::x_fastest({3, 3, 6}),
                            affine_of({h, h, h}))
                    .material(1, test::isotropic(E1, nu1))
                    .material(2, test::isotropic(E2, nu2))
                    .hold("z-", "z")
                    .move("z+", {0, 0, shift}, "z")
                    .build();
  for (const int z : {0, 6}) {
    test::add_prescribed(scene, {0, 0, z}, 0, 0, true);
    test::add_prescribed(scene, {0, 0, z}, 1, 0, true);
    test::add_prescribed(scene, {3, 0, z}, 1, 0, true);
  }
  test::sort_prescribed(scene);
  return scene;
}

TEST(FemSlidingAnalytic, BlocksThatSlideArePressedAsColumnsInSeries) {
  constexpr double shift = -1e-4;
  Scene scene = two_blocks(shift);
  scene.sliding = {{1, 2}};
  const double stress = shift / (3 * h / E1 + 3 * h / E2), expected = stress * 9 * h * h;
  for (const int degree : {1, 2}) {
    const Answer answer = answer_of(scene, degree);
    EXPECT_NEAR(test::force_of_moves(scene, answer), expected, 1e-6 * std::abs(expected)) << degree;
    ASSERT_EQ(answer.split.size(), 32U);
    const std::int64_t corner = scene.specimen.grid.node({3, 3, 3});
    for (const SplitNode& node : answer.split)
      if (node.node == corner) {
        const double strain = node.label == 1 ? -nu1 * stress / E1 : -nu2 * stress / E2;
        EXPECT_NEAR(node.displacement[0], 3 * h * strain, 1e-6 * h * std::abs(strain)) << degree;
      }
  }
}

TEST(FemSlidingAnalytic, NothingOfAMoveAlongTheBorderGoesAcrossIt) {
  Scene scene = two_blocks(0);
  for (Prescribed& p : scene.prescribed)
    if (p.component == 0 && scene.specimen.grid.node_at(p.node)[2] == 6)
      p.value = 1e-3, p.held = false;
  scene.sliding = {{1, 2}};
  for (const int degree : {1, 2}) {
    const Answer answer = answer_of(scene, degree);
    EXPECT_NEAR(test::force_of_moves(scene, answer), 0, 1e-8) << degree;
  }
}

TEST(FemConditionsAnalytic, AColumnOnSpringsSinksAsHookeSays) {
  constexpr double p = 2e3, k = 1e7;
  Scene scene;
  scene.specimen.shape = "box";
  scene.specimen.grid = Grid(3, {2, 3, 4}, {h, h, h});
  scene.materials = {test::isotropic(E1, nu1)};
  test::add_prescribed(scene, {0, 0, 0}, 0, 0, true);
  test::add_prescribed(scene, {0, 0, 0}, 1, 0, true);
  test::add_prescribed(scene, {2, 0, 0}, 1, 0, true);
  test::sort_prescribed(scene);
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 2; ++x) {
      scene.springs.push_back({scene.specimen.grid.cell({x, y, 0}), 2, false, k, {0, 0, 1}});
      scene.tractions.push_back({scene.specimen.grid.cell({x, y, 3}), 2, true, {0, 0, -p}});
    }
  for (const int degree : {1, 2}) {
    const Answer answer = answer_of(scene, degree);
    EXPECT_NEAR(answer.displacement(2, scene.specimen.grid.node({1, 1, 4})), -p / k - p * 4 * h / E1,
                1e-6 * p / k);
    EXPECT_NEAR(*answer.strain_energy, 0.5 * p * p / E1 * 24 * h * h * h, 1e-6 * p * p / E1 * 24 * h * h * h);
  }
}

TEST(FemConditionsAnalytic, CellsThatAreTissueInPartCarryTheirPart) {
  Scene scene;
  scene.specimen.shape = "box";
  scene.specimen.grid = Grid(3, {2, 2, 3}, {h, h, h});
  scene.materials = {test::isotropic(E1, nu1)};
  for (int y = 0; y <= 2; ++y)
    for (int x = 0; x <= 2; ++x) {
      test::add_prescribed(scene, {x, y, 0}, 2, 0, true);
      test::add_prescribed(scene, {x, y, 3}, 2, 1e-4, false);
    }
  test::add_prescribed(scene, {0, 0, 0}, 0, 0, true);
  test::add_prescribed(scene, {0, 0, 0}, 1, 0, true);
  test::add_prescribed(scene, {2, 0, 0}, 1, 0, true);
  test::sort_prescribed(scene);
  scene.specimen.tissue = {1, 0.25F, 1, 0.25F, 1, 0.25F, 1, 0.25F, 1, 0.25F, 1, 0.25F};
  scene.specimen.stiffness_ratio.assign(12, 2);
  const double expected = 2 * E1 * 1e-4 / (3 * h) * 2.5 * h * h;
  for (const int degree : {1, 2}) {
    const Answer answer = answer_of(scene, degree);
    EXPECT_NEAR(test::force_of_moves(scene, answer), expected, 1e-6 * expected) << degree;
  }
}

} // namespace
} // namespace maille::fem_ref
