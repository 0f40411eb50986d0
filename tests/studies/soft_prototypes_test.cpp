/// The prototypes of Gibson 1995 (Beyond volume rendering) as they are played from their files: the
/// deformable ones.

#include "studies/prototype_scenes.hpp"
#include "support/temporary_folder.hpp"

#include <algorithm>
#include <cmath>

namespace maille::studies {
namespace {
using test::done_of;
using test::mm;
using test::object_named;
using test::play_to_the_end;
using test::player_of;
using test::world_folder;

// Figure 7: the voxel that is moved takes its neighbours along once a link is as short, or as long, as it can
// be.
TEST(PrototypesAnalytic, AChainIsCompressedWhenPushedAndStretchedWhenPulled) {
  Player player = player_of("chain.toml", "chain_pushed_and_pulled.toml");
  constexpr double shortest = 0.6, longest = 1.5; // of its links [mm]
  std::vector<double> x;
  for (int i = 0; i < 9; ++i)
    x.push_back(16.5 + i);
  bool was_compressed = false, was_stretched = false;
  while (!player.is_at_end()) {
    const PlayedFrame frame = player.next();
    const double hand = 16.5 + (frame.number <= 32 ? 0.25 * static_cast<double>(frame.number)
                                                   : 8 - 0.25 * static_cast<double>(frame.number - 32));
    for (int i = 0; i < 9; ++i) {
      double& place = x[static_cast<std::size_t>(i)];
      place = std::clamp(place, hand + shortest * i, hand + longest * i);
      ASSERT_NEAR(player.world().position(0, i)[0] / mm, place, 1e-5)
          << "node " << i << ", frame " << frame.number;
    }
    const double length = x[8] - x[0];
    was_compressed = was_compressed || std::abs(length - 8 * shortest) < 1e-9;
    was_stretched = was_stretched || std::abs(length - 8 * longest) < 1e-9;
  }
  EXPECT_TRUE(was_compressed);
  EXPECT_TRUE(was_stretched);
}

TEST(PrototypesContract, TwoSoftBodiesPressEachOtherFlatAndNeitherEntersTheOther) {
  Player player = player_of("pressed.toml", "pressed_together.toml");
  const int left = object_named(player.world(), "left"), right = object_named(player.world(), "right");
  const auto frames = play_to_the_end(player);
  EXPECT_TRUE(frames.front().contacts.empty());
  EXPECT_FALSE(frames.back().contacts.empty());
  EXPECT_GT(frames.back().drives[0].force[0], 0); // the hand has to push
  double pressed_in = 0, pushed_back = 0;         // both give way
  for (const double u : player.world().displacement(left).component(0))
    pressed_in = std::max(pressed_in, 14 * mm - u);
  for (const double u : player.world().displacement(right).component(0))
    pushed_back = std::max(pushed_back, u);
  EXPECT_GT(pressed_in, 1 * mm);
  EXPECT_GT(pushed_back, 1 * mm);
}

TEST(PrototypesContract, AMuscleGivesWayToAProbeAndComesBack) {
  Player player = player_of("muscle.toml", "muscle_poked.toml");
  const int muscle = object_named(player.world(), "muscle");
  const auto lowest = [&] {
    double depth = 0;
    for (const double u : player.world().displacement(muscle).component(2))
      depth = std::max(depth, -u);
    return depth;
  };
  double deepest = 0, hardest = 0;
  while (!player.is_at_end()) {
    const PlayedFrame frame = player.next();
    ASSERT_EQ(player.world().n_penetrations(), 0) << "in frame " << frame.number;
    deepest = std::max(deepest, lowest());
    hardest = std::max(hardest, frame.drives[0].force.norm());
  }
  EXPECT_GT(deepest, 2 * mm);
  EXPECT_GT(hardest, 0);
  EXPECT_LT(lowest(), 0.01 * deepest);
}

// Analytic: single voxels before one another come to the faces before them, half a cell, and no further; what
// goes through them reaches the second body, which comes back to rest when the hand rests.
TEST(PrototypesAnalytic, VoxelsHandOnWhatTheyCannotMove) {
  Player player = player_of("handed_on.toml", "handed_on_pushed.toml");
  const deform::World& world = player.world();
  const int second = object_named(world, "second");
  int on_the_way = 0;
  std::int64_t handed_on = 0;
  double furthest = 0, now = 0;
  while (!player.is_at_end()) {
    const PlayedFrame frame = player.next();
    on_the_way += frame.status == Status::budget_reached;
    handed_on += frame.handed_on;
    now = 0;
    for (const double u : world.displacement(second).component(0))
      now = std::max(now, u);
    furthest = std::max(furthest, now);
    ASSERT_EQ(world.n_shared_cells(), 0) << "in frame " << frame.number;
  }
  EXPECT_GT(on_the_way, 20);
  EXPECT_GT(handed_on, 50);
  for (const auto& [pearl, face] : {std::pair{"pearl 1", 12.5}, {"pearl 2", 13.5}, {"pearl 3", 14.5}})
    EXPECT_NEAR(world.pose(object_named(world, pearl)).position[0] / mm, face, 1e-6) << pearl;
  EXPECT_GT(furthest, 0.1 * mm);
  EXPECT_LT(now, 0.1 * furthest);
}

// Nodes that stand closer than cells come into the cells of those that make way, and are asked to make way
// too.
TEST(PrototypesContract, AMuscleFinerThanTheWorldGivesWayToo) {
  std::string text = test::text_of(world_folder / "muscle.toml");
  for (const auto& [from, to] :
       {std::pair{"cells    = [36, 13, 13]", "cells = [40, 14, 14]\nspacing = \"0.9 mm\""},
        {"[\"6.5 mm\", \"5.5 mm\", \"5.5 mm\"]", "[\"6 mm\", \"5.7 mm\", \"5 mm\"]"}}) {
    ASSERT_NE(text.find(from), std::string::npos) << from;
    text.replace(text.find(from), std::string_view(from).size(), to);
  }
  const WorldScene scene = parse_world_scene(text);
  Player player(deform::World(scene), read_trajectory(world_folder / "muscle_poked.toml", scene));
  for (int i = 0; i < 8; ++i) {
    const PlayedFrame frame = player.next();
    EXPECT_EQ(done_of(frame), 1) << "in frame " << frame.number;
    ASSERT_EQ(player.world().n_penetrations(), 0);
  }
  double depth = 0;
  for (const double u : player.world().displacement(0).component(2))
    depth = std::max(depth, -u);
  EXPECT_GT(depth, 0.5 * mm);
}

} // namespace
} // namespace maille::studies
