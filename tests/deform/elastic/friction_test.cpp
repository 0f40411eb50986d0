/// Coulomb's friction of sliding borders in `coupled`, against closed forms.

#include "maille/deform/solve.hpp"
#include "maille/scene/plausibility.hpp"
#include "maille/scene/scene_builder.hpp"
#include "support/bodies/layers.hpp"
#include "support/kit.hpp"
#include "support/solved.hpp"

namespace maille::deform {
namespace {

constexpr double h = 1e-3, E = 100e3, mu = 0.3;

using test::force_of_moves;

/// Blocks of n x n x 4 cells on each other, labels 1 and 2; the lower one held at its lower face.
SceneBuilder two_blocks(int n, double nu) {
  const ElasticConstants matter = ElasticConstants::isotropic(E, nu);
  return test::layers({n, n, 8}, h, matter, matter);
}

// Truth: Coulomb. Where all of a border slips one way, what is drawn is mu times what presses.
TEST(FrictionAnalytic, ABlockThatIsDrawnFarTransmitsMuTimesWhatPressesIt) {
  Scene scene = two_blocks(4, 0.3).move("z+", {1e-3, 0, -2e-4}, "xyz").build();
  scene.relaxation.tolerance = 1e-7;
  scene.sliding = {{1, 2, mu}};
  const Answer answer = test::solved(scene, "coupled");
  const double drawn = force_of_moves(scene, answer, 0), pressed = -force_of_moves(scene, answer, 2);
  ASSERT_EQ(answer.rubbing.size(), 1U);
  EXPECT_EQ(answer.rubbing[0].slipping, 1);
  EXPECT_NEAR(answer.rubbing[0].pressed, pressed, 1e-4 * pressed);
  EXPECT_NEAR(answer.rubbing[0].rubbed, mu * pressed, 1e-4 * pressed);
  EXPECT_NEAR(drawn, mu * pressed, 0.01 * mu * pressed); // each node slips a little across, too
  EXPECT_GT(pressed, E * 2e-4 / (8 * h) * 16 * h * h);   // ends that are glued are stiffer than columns
}

// Truth: below that force nodes stick, and the blocks are one.
TEST(FrictionAnalytic, ABlockThatIsDrawnLittleIsGlued) {
  Scene scene = two_blocks(4, 0).move("z+", {2e-6, 0, -2e-4}, "xyz").build();
  scene.relaxation.tolerance = 1e-8;
  const Answer glued = solve(scene, "coupled");
  scene.sliding = {{1, 2, mu}};
  const Answer answer = test::solved(scene, "coupled");
  EXPECT_EQ(answer.rubbing.at(0).slipping, 0);
  double most = 0;
  for (std::size_t i = 0; i < answer.displacement.values().size(); ++i)
    most = std::max(most, std::abs(answer.displacement.values()[i] - glued.displacement.values()[i]));
  EXPECT_LT(most, 1e-6 * 2e-4);
  EXPECT_NEAR(force_of_moves(scene, answer, 0), force_of_moves(scene, glued, 0),
              1e-4 * force_of_moves(scene, glued, 0));
}

// Truth: statics. Under forces alone a block stays while it is drawn with less than mu times what presses
// it, and then all of that force goes through the border; with more nothing holds it.
TEST(FrictionAnalytic, ForcesBelowMuTimesThePressureHoldABlock) {
  constexpr double p = 2e3, area = 16 * h * h;
  const auto of_share = [&](double share) {
    Scene scene = two_blocks(4, 0).build();
    for (const auto& [label, z] : {std::pair(2, 7), std::pair(2, 4)})
      for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) {
          const std::int64_t cell = scene.specimen.grid.cell({x, y, z});
          ASSERT_EQ(scene.specimen.label[static_cast<std::size_t>(cell)], label);
          if (z == 7)
            scene.tractions.push_back({cell, 2, true, {0, 0, -p}});
          else if (x == 3) // drawn just above the border, so that it tilts little
            scene.tractions.push_back({cell, 0, true, {4 * share * mu * p, 0, 0}});
        }
    scene.sliding = {{1, 2, mu}};
    scene.relaxation.tolerance = 1e-6;
    EXPECT_EQ(remaining_rigid_motion(scene), "");
    const Answer answer = solve(scene, "coupled");
    if (share < 1) {
      ASSERT_EQ(answer.status, Status::done) << answer.message;
      double held = 0;
      for (std::size_t i = 0; i < answer.reaction.size(); ++i)
        held -= scene.prescribed[i].component == 0 ? answer.reaction[i] : 0;
      EXPECT_NEAR(held, share * mu * p * area, 1e-4 * mu * p * area);
      EXPECT_NEAR(answer.rubbing.at(0).pressed, p * area, 1e-3 * p * area);
      EXPECT_LE(answer.rubbing.at(0).rubbed, mu * p * area * (1 + 1e-4));
      return;
    }
    EXPECT_EQ(answer.status, Status::failed);
    EXPECT_NE(answer.message.find("label 2 (64 cells) can still move along x"), std::string::npos)
        << answer.message;
    EXPECT_NE(answer.message.find("does not hold what pulls there"), std::string::npos) << answer.message;
    EXPECT_TRUE(answer.displacement.empty());
  };
  of_share(0.5);
  of_share(0.9);
  of_share(1.1);
}

// Truth: a bar on a rough bed that is drawn at one end slips over the first T / q of it, q = mu p times its
// width, and its end moves by T^2 / (2 E A q); with nodes h apart, T = q h (m + 1/2), by q h^2 m (m + 1) /
// (2 E A).
TEST(FrictionAnalytic, ABarOnARoughBedSlipsAsFarAsItsPullReaches) {
  Scene scene;
  const auto [end_of_nodes, end_of_bar] = test::draw_on_rough_bed(h, E, scene);
  scene.relaxation.tolerance = 1e-7;
  const Answer answer = test::solved(scene, "coupled");
  double end = 0;
  for (const int y : {0, 1})
    end += answer.displacement(0, scene.specimen.grid.node({16, y, 2})) / 2;
  EXPECT_NEAR(end, end_of_nodes, 2e-3 * end);
  EXPECT_NEAR(end, end_of_bar, 1e-2 * end);
  EXPECT_NEAR(answer.rubbing.at(0).slipping, 8.0 / 17, 1.5 / 17);
}

TEST(FrictionContract, MethodsThatKnowNoForcesRefuseItInWords) {
  Scene scene = two_blocks(2, 0).move("z+", {1e-4, 0, -1e-4}, "xyz").build();
  scene.sliding = {{1, 2, mu}};
  for (const char* method : {"limits", "relaxed", "sweep", "literal", "dijkstra"}) {
    const Answer answer = solve(scene, method);
    EXPECT_EQ(answer.status, Status::refused) << method;
    EXPECT_NE(answer.message.find("has friction"), std::string::npos) << answer.message;
  }
}

} // namespace
} // namespace maille::deform
