/// Coulomb's friction of sliding borders in finite elements, against closed forms.

#include "maille/fem_ref/solve.hpp"
#include "support/bodies/layers.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace maille::fem_ref {
namespace {

constexpr double h = 1e-3, E = 100e3, mu = 0.3;

using tests::force_of_moves;

SceneBuilder layers(const Index3& cells, const ElasticConstants& below, const ElasticConstants& above) {
  return tests::layers(cells, h, below, above);
}

// Truth: Coulomb. Where all of a border slips one way, what is drawn is mu times what presses.
TEST(FemFrictionAnalytic, ABlockThatIsDrawnFarTransmitsMuTimesWhatPressesIt) {
  const ElasticConstants matter = ElasticConstants::isotropic(E, 0);
  Scene scene = layers({3, 3, 6}, matter, matter).move("z+", {1e-3, 0, -2e-4}, "xyz").build();
  scene.relaxation.tolerance = 1e-6;
  scene.sliding = {{1, 2, mu}};
  const Answer answer = solve(scene, Options{}).answer;
  ASSERT_EQ(answer.status, Status::done) << answer.message;
  const double drawn = force_of_moves(scene, answer, 0), pressed = -force_of_moves(scene, answer, 2);
  EXPECT_NEAR(pressed, E * 2e-4 / (6 * h) * 9 * h * h, 1e-6 * pressed);
  EXPECT_EQ(answer.rubbing.at(0).slipping, 1);
  EXPECT_NEAR(answer.rubbing.at(0).pressed, pressed, 1e-4 * pressed);
  EXPECT_NEAR(drawn, mu * pressed, 1e-4 * pressed);
}

// Truth: statics. Under forces alone a block stays while it is drawn with less than mu times what presses
// it, and then all of that force goes through the border; with more nothing holds it.
TEST(FemFrictionAnalytic, ABlockUnderForcesStaysBelowMuTimesWhatPressesItAndSlidesAwayAbove) {
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
      EXPECT_NE(answer.message.find("label 2 (27 cells) can still move along x"), std::string::npos)
          << answer.message;
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
  constexpr int n = 16, m = 8;
  // So little friction that its moment, at the foot of the bar, shifts no pressure to speak of.
  constexpr double little = 0.02, shift = -1e-5, p = -shift * E / h, q = little * p * h,
                   pull = q * h * (m + 0.5);
  // Stiff in shear, so that sections stay plane; no Poisson effect.
  Scene scene =
      layers({n, 1, 2}, ElasticConstants::isotropic(1e4 * E, 0), {{E, E, E}, 0, 0, 0, 50 * E, 50 * E, 50 * E})
          .move("z+", {0, 0, shift}, "z")
          .build();
  scene.tractions.push_back({scene.specimen.grid.cell({n - 1, 0, 1}), 0, true, {pull / (h * h), 0, 0}});
  scene.sliding = {{1, 2, little}};
  scene.relaxation.tolerance = 1e-6;
  const Answer answer = solve(scene, Options{}).answer;
  ASSERT_EQ(answer.status, Status::done) << answer.message;
  const double end = answer.displacement(0, scene.specimen.grid.node({n, 0, 2}));
  EXPECT_NEAR(end, q * h * h * m * (m + 1) / (2 * E * h * h), 3e-3 * end);
}

TEST(FemFrictionContract, QuadraticElementsRefuseItInWords) {
  const ElasticConstants matter = ElasticConstants::isotropic(E, 0);
  Scene scene = layers({2, 2, 2}, matter, matter).move("z+", {1e-4, 0, -1e-4}, "xyz").build();
  scene.sliding = {{1, 2, mu}};
  Options options;
  options.degree = 2;
  const Answer answer = solve(scene, options).answer;
  EXPECT_EQ(answer.status, Status::refused);
  EXPECT_NE(answer.message.find("friction"), std::string::npos) << answer.message;
}

} // namespace
} // namespace maille::fem_ref
