/// Frames that can be gone back to, and the file of them.

#include "live/by_hand.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <random>

namespace maille::live {
namespace {
using test::block_world;
using test::mm;
using test::top_middle;

DriveSpan pulled(const WorldScene& world, const Vec3& by) {
  DriveSpan span;
  span.nodes = std::vector{top_middle(world)};
  span.by = by;
  return span;
}

/// What the same file gives when it is read and played, without any of our timeline.
Displacement replayed(const std::string& text, WorldScene scene) {
  const Trajectory trajectory = parse_trajectory(text, "hand.csv", scene);
  apply_settings(trajectory.settings, scene);
  deform::World world(scene);
  deform::TrajectoryDrives drives(world);
  for (std::int64_t frame = 1; frame <= trajectory.n_frames; ++frame) {
    std::vector<DriveSpan> spans;
    for (const DriveSpan& span : trajectory.spans)
      if (span.first_frame == frame)
        spans.push_back(span);
    const auto asked = drives.begin_frame(world, spans, frame);
    world.advance(asked);
  }
  return world.displacement(0);
}

class LiveTimelineContract : public testing::TestWithParam<const char*> {};

TEST_P(LiveTimelineContract, WhatIsUndoneIsAsIfItHadNeverBeen) {
  const WorldScene scene = block_world(GetParam());
  Timeline timeline(scene, {}, std::nullopt);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> step(-0.4 * mm, 0.4 * mm);
  const auto gesture = [&] {
    timeline.begin_gesture();
    for (int i = 0; i < 3; ++i)
      timeline.add_frame({pulled(scene, {step(random), step(random), step(random)})});
  };
  gesture();
  const Displacement one = timeline.world().displacement(0);
  gesture();
  const Displacement two = timeline.world().displacement(0);
  ASSERT_NE(one, two);
  timeline.undo();
  EXPECT_EQ(timeline.frame(), 3);
  EXPECT_EQ(timeline.world().displacement(0), one);
  timeline.redo();
  EXPECT_EQ(timeline.world().displacement(0), two);
  timeline.go_to(0);
  EXPECT_EQ(timeline.world().displacement(0), Displacement(scene.objects[0].scene.specimen.grid));
  timeline.go_to(3);
  EXPECT_EQ(timeline.world().displacement(0), one);
  gesture(); // another way: what was undone is gone
  EXPECT_EQ(timeline.n_frames(), 6);
  EXPECT_FALSE(timeline.can_redo());
}

TEST_P(LiveTimelineContract, TheFileIsTheWayToThePresentStateToTheBit) {
  const WorldScene scene = block_world(GetParam());
  const std::filesystem::path file =
      std::filesystem::path(testing::TempDir()) / (std::string("live_timeline_") + GetParam() + ".csv");
  {
    Timeline timeline(scene, {}, file);
    std::mt19937 random(7);
    std::normal_distribution<double> step(0, 0.3 * mm);
    for (int i = 0; i < 12; ++i) {
      if (i % 4 == 0)
        timeline.begin_gesture();
      timeline.add_frame({pulled(scene, {step(random), step(random), step(random)})});
      EXPECT_EQ(maille::test::text_of(file), timeline.text()) << "the file is behind after frame " << i;
    }
    timeline.undo();
    EXPECT_EQ(maille::test::text_of(file), timeline.text());
    EXPECT_EQ(replayed(maille::test::text_of(file), scene), timeline.world().displacement(0));
    timeline.begin_gesture();
    DriveSpan release;
    release.release = true;
    timeline.add_frame({release, pulled(scene, {0.1 * mm, 0, 0})});
    timeline.change({0, "stiffness", "2"});
    timeline.change({0, "limits", "1.5 0.5 0.4"});
    EXPECT_EQ(replayed(maille::test::text_of(file), scene), timeline.world().displacement(0));
  }
  std::filesystem::remove(file);
}

INSTANTIATE_TEST_SUITE_P(Methods, LiveTimelineContract, testing::Values("limits", "relaxed", "coupled"),
                         [](const auto& each) { return std::string(each.param); });

// The same movements of the hand, by another method: as if it had been that one all along.
TEST(LiveTimelineOracle, AChangedMethodPlaysTheSameHandAgain) {
  const WorldScene limits = block_world("limits"), coupled = block_world("coupled");
  Timeline changed(limits, {}, std::nullopt), always(coupled, {}, std::nullopt);
  for (Timeline* each : {&changed, &always})
    for (int i = 0; i < 3; ++i)
      each->add_frame({pulled(limits, {0, 0.2 * mm, 0.1 * mm})});
  changed.change({std::nullopt, "method", "coupled"});
  EXPECT_EQ(changed.world().displacement(0), always.world().displacement(0));
  EXPECT_THROW(changed.change({std::nullopt, "method", "guess"}), InputError);
  EXPECT_THROW(changed.change({0, "stiffness", "-1"}), InputError);
  EXPECT_EQ(changed.world().displacement(0), always.world().displacement(0));
}

TEST(LiveTimelineContract, AFileThatCannotBeWrittenIsSaid) {
  EXPECT_THROW(Timeline(block_world("limits"), {}, "/nowhere/at/all.csv"), std::runtime_error);
}

// A world that is copied and goes on as its original does.
TEST(LiveTimelineContract, WorldsOfSeveralObjectsAreGoneBackInToTheBit) {
  const WorldScene scene = read_world_scene(test::world_folder / "muscle.toml");
  Timeline timeline(scene, {}, std::nullopt);
  DriveSpan down;
  down.object = 1;
  down.by = {0, 0, -1 * mm};
  std::vector<Displacement> states;
  for (int i = 0; i < 6; ++i) {
    timeline.begin_gesture();
    timeline.add_frame({down});
    states.push_back(timeline.world().displacement(0));
  }
  timeline.undo();
  EXPECT_EQ(timeline.world().displacement(0), states[4]);
  timeline.add_frame({down});
  EXPECT_EQ(timeline.world().displacement(0), states[5]);
  EXPECT_EQ(timeline.world().n_shared_cells(), 0);
}

} // namespace
} // namespace maille::live
