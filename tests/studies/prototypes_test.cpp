/// The prototypes of Gibson 1995 (Beyond volume rendering) as they are played from their files.

#include "studies/prototype_scenes.hpp"
#include "support/kit.hpp"

#include <Eigen/Geometry>

namespace maille::studies {
namespace {

using test::done_of;
using test::mm;
using test::object_named;
using test::play_to_the_end;
using test::player_of;
using test::world_folder;

TEST(PrototypesContract, TheMazeIsWalkedThroughAndNoWallIsPulledThrough) {
  Player player = player_of("maze.toml", "maze_path.toml");
  const int piece = object_named(player.world(), "piece");
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  bool has_been_there = false, has_slid = false;
  while (!player.is_at_end()) {
    const PlayedFrame frame = player.next();
    ASSERT_EQ(player.world().n_penetrations(), 0) << "in frame " << frame.number;
    at = player.world().pose(piece).position / mm;
    has_been_there = has_been_there || (at[0] > 56 && at[1] > 40); // the room in the upper right corner
    has_slid = has_slid || (!frame.contacts.empty() && done_of(frame) < 1);
  }
  EXPECT_TRUE(has_been_there);
  EXPECT_TRUE(has_slid);
  EXPECT_GT((at - Eigen::Vector3d(2, 2, 0)).norm(), 8); // pulled straight back, it is held by walls
}

// The pieces were cut from one picture, so together they fill it.
TEST(PrototypesAnalytic, ThePiecesOfThePuzzleFitTogether) {
  Player player = player_of("puzzle.toml", "puzzle_solved.toml");
  for (const PlayedFrame& frame : play_to_the_end(player))
    EXPECT_NEAR(done_of(frame), 1, 1e-9) << "in frame " << frame.number;
  const deform::OccupancyMap& map = player.world().map();
  EXPECT_EQ(map.n_occupied(), 48 * 32);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 48; ++x)
      ASSERT_TRUE(map.is_occupied({24 + x, 4 + y, 0})) << x << ", " << y;
}

TEST(PrototypesContract, APieceOfThePuzzleFitsIntoNoOtherPlace) {
  WorldScene scene = read_world_scene(world_folder / "puzzle.toml");
  for (WorldObject& object : scene.objects) // all in their places but two of the upper row
    if (object.name != "piece_11" && object.name != "piece_21")
      object.position = {24 * mm, 4 * mm, 0};
    else if (object.name == "piece_21")
      object.position = {(24 - 16) * mm, (4 + 30) * mm, 0}; // over the place of piece_11
  std::erase_if(scene.objects, [](const WorldObject& object) { return object.name == "piece_11"; });
  deform::World world(scene);
  deform::Drive drive;
  drive.object = object_named(world, "piece_21");
  for (int i = 0; i < world.n_objects(); ++i) { // a hand on each of the others
    deform::Drive held;
    held.object = i;
    world.advance({&held, 1});
  }
  drive.motion.by = {0, -30 * mm, 0};
  EXPECT_LT(world.advance({&drive, 1}).drives[0].fraction, 1 - 1.0 / 30);
  EXPECT_EQ(world.n_penetrations(), 0);
}

TEST(PrototypesContract, TheWasherGoesOntoTheBoltAndTheNutIsStoppedByTheThread) {
  Player player = player_of("bolt.toml", "bolt_assembled.toml");
  const int washer = object_named(player.world(), "washer"), nut = object_named(player.world(), "nut");
  const auto height = [&](int object) { return player.world().pose(object).position[2] / mm; };
  const auto play = [&](int frames) {
    for (int i = 0; i < frames; ++i) {
      player.next();
      ASSERT_EQ(player.world().n_penetrations(), 0);
    }
  };
  play(30);
  // The head's top is at 2 + 8 mm; there the centres of the washer's lowest voxels stop.
  EXPECT_NEAR(height(washer), 10 - 0.5, 1e-6);
  play(20);
  const double stopped = height(nut);
  EXPECT_LT(stopped, 46 + 1);  // at the top of the bolt, 2 + 44 mm
  EXPECT_GT(stopped, 46 - 10); // and not a turn further
  play(4 + 12);
  play(48);
  EXPECT_TRUE(player.is_at_end());
  // Turned twice along the thread, of 10 mm a turn.
  EXPECT_NEAR(height(nut), 47 - 20, 1e-6);
}

TEST(PrototypesData, AFingertipFeelsTheSkull) {
  const char* const data = std::getenv("MAILLE_DATA");
  if (data == nullptr || !std::filesystem::exists(std::filesystem::path(data) / "head_ct/headsq.mha"))
    GTEST_SKIP() << "MAILLE_DATA names no folder with head_ct/headsq.mha";
  Player player = player_of("head.toml", "head_felt.csv");
  int felt = 0;
  while (!player.is_at_end())
    for (const PlayedContact& contact : player.next().contacts)
      felt += contact.other == 0;
  EXPECT_GT(felt, 50);
  EXPECT_EQ(player.world().n_penetrations(), 0);
}

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

TEST(PrototypesContract, TwoSoftBodiesPressEachOther) {
  Player player = player_of("pressed.toml", "pressed_together.toml");
  const int left = object_named(player.world(), "left"), right = object_named(player.world(), "right");
  const auto frames = play_to_the_end(player);
  EXPECT_TRUE(frames.front().contacts.empty());
  EXPECT_FALSE(frames.back().contacts.empty());
  EXPECT_GT(frames.back().drives[0].force[0], 0); // the hand has to push
  // Both give way.
  EXPECT_LT(std::ranges::min(player.world().displacement(left).component(0)), (14 - 1) * mm);
  EXPECT_GT(std::ranges::max(player.world().displacement(right).component(0)), 1 * mm);
}

TEST(PrototypesContract, AMuscleGivesWayToAProbeAndComesBack) {
  Player player = player_of("muscle.toml", "muscle_poked.toml");
  const int muscle = object_named(player.world(), "muscle");
  const auto lowest = [&] {
    return -std::min(0.0, std::ranges::min(player.world().displacement(muscle).component(2)));
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
  EXPECT_LT(std::ranges::min(player.world().displacement(0).component(2)), -0.5 * mm);
}

} // namespace
} // namespace maille::studies
