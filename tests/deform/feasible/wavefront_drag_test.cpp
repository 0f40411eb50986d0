#include "feasible/wavefront/wavefront.hpp"

#include "support/bodies/holed_bodies.hpp"
#include "support/bodies/named_bodies.hpp"
#include "support/kit.hpp"
#include "support/quanta.hpp"
#include "support/tiled_state.hpp"

#include <hwy/targets.h>

namespace maille::deform {
namespace {

using test::Dice;
using test::state_of;

/// The state after moving to k / steps of the scene's moves for k = 1 ... steps.
Displacement dragged(const Scene& scene, const LinkLimits& limits, int steps) {
  TiledBody body(scene, limits);
  for (int k = 1; k <= steps; ++k)
    body.move(scaled(scene, double(k) / steps).prescribed);
  return state_of(scene, body);
}

// ---- drags in steps ----

TEST(WavefrontDragConsistent, AMonotoneDragEndsTheSameInAnyNumberOfSteps) {
  int n_compared = 0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    auto [random, scene, limits, body] = test::HoledTiles(seed);
    const std::vector<Prescribed> clipped = body.move(scene.prescribed);
    if (!std::ranges::equal(clipped, scene.prescribed, {}, &Prescribed::value, &Prescribed::value))
      continue; // a request that is cut may turn back on its way
    ++n_compared;
    const Displacement at_once = state_of(scene, body);
    for (const int steps : {2, 7, 50})
      ASSERT_EQ(dragged(scene, limits, steps), at_once) << "seed " << seed;
  }
  EXPECT_GE(n_compared, 50);
}

TEST(WavefrontDragContract, ALocalDragVisitsTheTilesItChangesAndNoOthers) {
  Scene scene = named_body("random", 64);
  const LinkLimits limits(scene);
  const Arena arena;
  const Arena::Open open(arena);
  TiledBody body(scene, limits);
  for (Prescribed& p : scene.prescribed)
    p.value = 0.5; // links give way by 0.03 on average: some ten nodes move along each axis
  body.move(scene.prescribed);
  EXPECT_LE(body.n_visits(), 3 * 60);
  EXPECT_EQ(body.n_tiles(), 512);
  EXPECT_LE(arena.present(), std::int64_t{12} * 1024 * 1024); // of 25 if all had been visited
}

TEST(WavefrontDragConsistent, RaisingAndLoweringOneByOneIsAMove) {
  int n_compared = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    auto [random, scene, limits, body] = test::HoledTiles(seed);
    TiledBody by_hand(scene, limits);
    const std::vector<Prescribed> clipped = body.move(scene.prescribed);
    for (const bool up : {true, false})
      for (const Prescribed& p : clipped) {
        const PathEnd end{p.node, p.value};
        up ? by_hand.raise(p.component, {&end, 1}) : by_hand.lower(p.component, {&end, 1});
      }
    Displacement expected = state_of(scene, by_hand);
    for (const Prescribed& p : clipped)
      expected(p.component, p.node) = p.value;
    for (std::size_t b = 0; b < expected.n_components(); ++b)
      if (by_hand.quantum(int(b)) == body.quantum(int(b))) { // and not grown on the way
        ++n_compared;
        ASSERT_TRUE(std::ranges::equal(state_of(scene, body).component(b), expected.component(b)))
            << "seed " << seed;
      }
  }
  EXPECT_GE(n_compared, 60);
}

// ---- the same bits ----

TEST(WavefrontBitsConsistent, AnyVectorInstructionsGiveTheSameBits) {
  std::vector<Scene> scenes;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    std::mt19937 random(seed);
    scenes.push_back(test::holed_body(random));
  }
  scenes.push_back(named_body("bore", 40)); // has tiles inside one kind of matter
  std::vector<Displacement> expected;
  int n_targets = 0;
  const std::int64_t all = hwy::SupportedTargets();
  for (std::int64_t rest = all; rest != 0; rest &= rest - 1) {
    hwy::SetSupportedTargetsForTest(rest & -rest);
    ++n_targets;
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      const LinkLimits limits(scenes[i]);
      TiledBody body(scenes[i], limits);
      body.move(scenes[i].prescribed);
      const Displacement u = state_of(scenes[i], body);
      if (n_targets == 1)
        expected.push_back(u);
      else
        EXPECT_EQ(u, expected[i]) << hwy::TargetName(rest & -rest) << " seed " << i + 1;
    }
  }
  hwy::SetSupportedTargetsForTest(0); // all again
  EXPECT_GE(n_targets, 2);
}

TEST(WavefrontBitsConsistent, TheOrderOfHandlesChangesNoBit) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    auto [random, scene, limits, body] = test::HoledTiles(seed);
    body.move(scene.prescribed);
    const Displacement expected = state_of(scene, body);
    for (int i = 0; i < 3; ++i) {
      std::ranges::shuffle(scene.prescribed, random);
      TiledBody again(scene, limits);
      again.move(scene.prescribed);
      ASSERT_EQ(state_of(scene, again), expected) << "seed " << seed;
    }
  }
}

// ---- far away ----

/// The part of `random` that is one piece, moved by one handle.
Scene one_piece(double by) {
  Scene scene = named_body("random", 20);
  for (Prescribed& p : scene.prescribed)
    p.value = by;
  return scene;
}

TEST(WavefrontFarAnalytic, AHandleAHundredBodiesAwayCostsNoAccuracy) {
  // 32 is beyond what the slack of 20 nodes adds up to (19 times 0.4 + 0.15 + 0.15 = 13.3), so all nodes
  // follow, and from there on the body only shifts. Dyadic shifts: to the bit.
  const Scene near = one_piece(32), far = one_piece(2048), farther = one_piece(-1048576);
  const LinkLimits limits(near);
  TiledBody at(near, limits), away(far, limits), beyond(farther, limits);
  at.move(near.prescribed);
  away.move(far.prescribed);
  EXPECT_EQ(away.quantum(0), at.quantum(0));
  const Displacement u = state_of(near, at), v = state_of(near, away);
  for (std::size_t n = 0; n < u.values().size(); ++n)
    ASSERT_EQ(v.values()[n], u.values()[n] + (2048 - 32));

  // From there 30 bodies on, in one step and in many: still no coarser.
  TiledBody again(near, limits);
  again.move(near.prescribed);
  again.move(far.prescribed);
  EXPECT_EQ(again.quantum(0), at.quantum(0));
  EXPECT_EQ(state_of(near, again), v);
  beyond.move(farther.prescribed);
  EXPECT_EQ(beyond.quantum(0), at.quantum(0));
  for (int k = 1; k <= 300; ++k)
    at.move(one_piece(32 + (2048 - 32) / 300.0 * k).prescribed);
  at.move(far.prescribed);
  EXPECT_EQ(state_of(near, at), v);
}

TEST(WavefrontFarAnalytic, AnIslandFarAwayLeavesTheOtherOneAtRest) {
  Scene scene = test::lattice_box({30, 3}, test::even_limits(1.25, 0.75, 0.25));
  scene.specimen.material_id.assign(90, 0);
  for (const int x : {14, 15})
    for (const int y : {0, 1, 2})
      scene.specimen.material_id[std::size_t(x + 30 * y)] = no_material;
  test::move(scene, {0, 0, 0}, {65536, -65536, 0});
  const LinkLimits limits(scene);
  TiledBody body(scene, limits);
  body.move(scene.prescribed);
  const Displacement u = state_of(scene, body);
  const Grid& grid = scene.specimen.grid;
  for (std::int64_t n = 0; n < grid.n_nodes(); ++n) {
    const Index3 at = grid.node_at(n);
    // The cone of one slope an axis, where it reaches; the quanta are those that span both islands.
    const double drop_x = 0.25 * at[0] + 0.25 * at[1];
    EXPECT_EQ(u(0, n), at[0] <= 14 ? 65536 - drop_x : 0) << n;
    EXPECT_EQ(u(1, n), at[0] <= 14 ? -65536 + drop_x : 0) << n;
  }
}

} // namespace
} // namespace maille::deform
