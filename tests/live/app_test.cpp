/// The window's whole way, from events to pictures, without a screen.

#include "live/by_hand.hpp"
#include "support/kit.hpp"

namespace maille::live {
namespace {

using test::at;
using test::dragged;
using test::mm;
using test::played;
using test::world_folder;

std::vector<std::array<double, 2>> in_metres(std::vector<std::array<double, 2>> places, double x, double y) {
  for (auto& place : places)
    place = {(place[0] - x) * mm, (place[1] - y) * mm};
  return places;
}

/// What a recorded file gives when it is read and played, without any of our timeline.
struct Replayed {
  Replayed(const std::string& text, WorldScene scene) {
    const Trajectory read = parse_trajectory(text, "hand.csv", scene);
    apply_settings(read.settings, scene);
    world.emplace(scene);
    drives.emplace(*world);
    for (std::int64_t frame = 1; frame <= read.n_frames; ++frame) {
      std::vector<DriveSpan> spans;
      for (const DriveSpan& span : read.spans)
        if (span.first_frame == frame)
          spans.push_back(span);
      world->advance(drives->begin_frame(*world, spans, frame));
    }
  }
  std::optional<deform::World> world;
  std::optional<deform::TrajectoryDrives> drives;
};

/// Where the frame of an object is at the end of a recorded trajectory.
deform::Pose end_of(const std::string& trajectory, const WorldScene& scene, std::size_t object) {
  Replayed replayed(trajectory, scene);
  return replayed.drives->frame_now(*replayed.world, object);
}

TEST(LiveAppContract, TheMazeIsWalkedByThePointer) {
  const WorldScene scene = read_world_scene(world_folder / "maze.toml");
  HeadlessWindow window(640, 480);
  using Places = std::vector<std::array<double, 2>>;
  const Places way{{2, 28.5},  {20.5, 26}, {18, 15.5}, {7.5, 18},  {10, 7.5},  {20.5, 10},
                   {18, -0.5}, {44.5, 2},  {42, 12.5}, {23.5, 10}, {26, 20.5}, {60.5, 18},
                   {58, 28.5}, {47.5, 26}, {50, 36.5}, {39.5, 34}, {42, 44.5}, {60.5, 42}};
  // The piece begins at (2, 2); it is taken in a cell of its own, the lower left one of its middle row.
  const LiveReport report =
      played(world_folder / "maze.toml", dragged(scene, {4.5 * mm, 4.5 * mm}, in_metres(way, 2, 2)), window);
  const Eigen::Vector3d end = end_of(report.trajectory, scene, 1).position / mm;
  EXPECT_GT(end[0], 56); // the room in the upper right corner
  EXPECT_GT(end[1], 40);
  EXPECT_EQ(report.penetrations, 0);
  EXPECT_GT(report.pictures, 50);
  EXPECT_TRUE(report.messages.empty());
}

TEST(LiveAppContract, ThePuzzleIsSolvedByThePointer) {
  const WorldScene scene = read_world_scene(world_folder / "puzzle.toml");
  // As puzzle_solved.toml has it: which piece, and where its frame goes.
  const std::vector<std::pair<std::size_t, std::vector<std::array<double, 2>>>> moves{
      {1, {{24, 4}}},
      {2, {{58, 4}, {24, 4}}},
      {3, {{24, 26}, {24, 4}}},
      {4, {{24, 36}, {24, 4}}},
      {5, {{24, 37}, {24, 4}}}};
  std::vector<ScriptedEvent> script;
  for (const auto& [piece, places] : moves) {
    const WorldObject& object = scene.objects[piece];
    const Specimen& body = object.scene.specimen;
    const Vec3 middle = body.position({body.grid.cells()[0] / 2, body.grid.cells()[1] / 2, 0});
    const auto drag =
        dragged(scene, {object.position[0] + middle[0] + 0.3 * mm, object.position[1] + middle[1] + 0.3 * mm},
                in_metres(places, object.position[0] / mm, object.position[1] / mm));
    script.insert(script.end(), drag.begin(), drag.end());
  }
  HeadlessWindow window(640, 480);
  const LiveReport report = played(world_folder / "puzzle.toml", script, window);
  for (std::size_t piece = 0; piece < scene.objects.size(); ++piece) {
    const Eigen::Vector3d end = end_of(report.trajectory, scene, piece).position / mm;
    EXPECT_NEAR((end - Eigen::Vector3d(24, 4, 0)).norm(), 0, 1e-6) << scene.objects[piece].name;
  }
  EXPECT_EQ(report.penetrations, 0);
}

TEST(LiveAppContract, WithoutASceneThereIsAMenu) {
  HeadlessWindow window(320, 240);
  LiveSettings settings;
  settings.menu = standard_menu(MAILLE_SCENES);
  const LiveReport report =
      played({}, {test::event(EventKind::widget, "open maze"), test::event(EventKind::widget, "menu")},
             window, settings);
  EXPECT_GT(report.pictures, 0);
  EXPECT_NE(window.widget("open puzzle"), nullptr); // the menu again
  for (const Prototype& each : settings.menu)
    EXPECT_TRUE(std::filesystem::exists(each.scene)) << each.scene;
}

TEST(LiveAppContract, AFileSaysWhatToDoAndF1ListsTheKeys) {
  const auto says = [](const HeadlessWindow& window, std::string_view what) {
    return std::ranges::any_of(window.shown().panel, [&](const Widget& widget) {
      return widget.label.find(what) != std::string::npos;
    });
  };
  const ScriptedEvent key = test::key("F1");
  for (const char* file : {"eight.toml", "chain.toml", "puzzle.toml"}) {
    HeadlessWindow window(320, 240);
    (void)played(world_folder / file, {{0, Event()}}, window);
    EXPECT_TRUE(says(window, "Drag")) << file;
    EXPECT_FALSE(says(window, "Ctrl+Q"));
    (void)played(world_folder / file, {key}, window);
    EXPECT_TRUE(says(window, "Ctrl+Q")) << file;
    (void)played(world_folder / file, {key, key}, window);
    EXPECT_FALSE(says(window, "Ctrl+Q")) << file;
  }
}

TEST(LiveAppContract, FaultsOfASceneAreShownAllOfThem) {
  const maille::test::TemporaryFolder folder;
  const auto file = folder.write(
      "faulty.toml",
      "[world]\ncells = [8, 8]\nspacing = \"-1 mm\"\n[[object]]\nname = \"a\"\nkind = \"soft\"\n");
  HeadlessWindow window(320, 240);
  const LiveReport report = played(file, {{0, Event()}}, window);
  EXPECT_GE(report.messages.size(), 2u);
  std::size_t shown = 0;
  for (const Widget& widget : window.shown().panel)
    shown += widget.emphasis;
  EXPECT_EQ(shown, report.messages.size());
}

TEST(LiveAppContract, MethodsAreSwitchedAndToldApart) {
  HeadlessWindow window(160, 120);
  const LiveReport report =
      played(std::filesystem::path(MAILLE_SCENES) / "poke_given_limits.toml",
             {test::pointer(EventKind::pointer_down, 80, 60), test::pointer(EventKind::pointer_move, 84, 50),
              test::pointer(EventKind::pointer_up, 84, 50, true), // pinned
              test::key("2"), test::key("3"), test::key("1"), test::key("3")},
             window);
  EXPECT_TRUE(report.messages.empty()) << report.messages.front();
  EXPECT_TRUE(test::has(report.trajectory, "method"));
  EXPECT_TRUE(test::has(report.trajectory, "body")) << "nothing was taken: " << report.trajectory;
  bool says_coupled = false;
  for (const OverlayText& text : window.shown().texts)
    says_coupled = says_coupled || text.text.starts_with("coupled");
  EXPECT_TRUE(says_coupled);
}

TEST(LiveAppContract, ASizeOfNothingIsNoCrash) {
  HeadlessWindow window(320, 240);
  std::vector<ScriptedEvent> script;
  for (const auto& [width, height] :
       std::vector<std::pair<double, double>>{{0, 0}, {1, 1}, {3, 400}, {400, 2}, {320, 240}}) {
    script.push_back(test::pointer(EventKind::resize, width, height));
    script.push_back(test::pointer(EventKind::pointer_down, 0, 0));
    script.push_back(test::pointer(EventKind::pointer_up, 0, 0));
  }
  const LiveReport report = played(world_folder / "maze.toml", script, window);
  EXPECT_EQ(report.events, 15);
}

TEST(LiveAppContract, ClosedInMidDragNothingIsLost) {
  const WorldScene scene = read_world_scene(world_folder / "maze.toml");
  const maille::test::TemporaryFolder folder;
  HeadlessWindow window(640, 480);
  LiveSettings settings;
  settings.record = folder / "mid_drag.csv";
  auto script = dragged(scene, {4.5 * mm, 4.5 * mm}, {{0, 20 * mm}});
  script.back() = test::event(EventKind::close); // in place of letting go
  const LiveReport report = played(world_folder / "maze.toml", script, window, settings);
  const std::string text = maille::test::text_of(folder / "mid_drag.csv");
  EXPECT_EQ(text, report.trajectory);
  EXPECT_NEAR(end_of(text, scene, 1).position[1], 22 * mm, 1e-3 * mm);
}

/// Frames that can be gone back to, and the file of them.

using test::block_world;
using test::top_middle;

DriveSpan pulled(const WorldScene& world, const Vec3& by) {
  DriveSpan span;
  span.nodes = std::vector{top_middle(world)};
  span.by = by;
  return span;
}

Displacement replayed(const std::string& text, const WorldScene& scene) {
  return Replayed(text, scene).world->displacement(0);
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
  const maille::test::TemporaryFolder folder;
  const auto recorded = [&] { return maille::test::text_of(folder / "timeline.csv"); };
  Timeline timeline(scene, {}, folder / "timeline.csv");
  std::mt19937 random(7);
  std::normal_distribution<double> step(0, 0.3 * mm);
  for (int i = 0; i < 12; ++i) {
    if (i % 4 == 0)
      timeline.begin_gesture();
    timeline.add_frame({pulled(scene, {step(random), step(random), step(random)})});
    EXPECT_EQ(recorded(), timeline.text()) << "the file is behind after frame " << i;
  }
  timeline.undo();
  EXPECT_EQ(recorded(), timeline.text());
  EXPECT_EQ(replayed(recorded(), scene), timeline.world().displacement(0));
  timeline.begin_gesture();
  DriveSpan release;
  release.release = true;
  timeline.add_frame({release, pulled(scene, {0.1 * mm, 0, 0})});
  timeline.change({0, "stiffness", "2"});
  timeline.change({0, "limits", "1.5 0.5 0.4"});
  EXPECT_EQ(replayed(recorded(), scene), timeline.world().displacement(0));
}

INSTANTIATE_TEST_SUITE_P(Methods, LiveTimelineContract, testing::Values("limits", "relaxed", "coupled"),
                         [](const auto& each) { return std::string(each.param); });

// The same movements of the hand, by another method: as if it had been that one all along.
TEST(LiveTimelineConsistent, AChangedMethodPlaysTheSameHandAgain) {
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

/// Scripts of events, and their faults.

TEST(LiveScriptContract, EventsAreReadAsTheyStand) {
  const auto script = parse_script("# a film\n"
                                   "time [s],event,x,y,button,name,value\n"
                                   "0,down,10,20,,,\n"
                                   "0.5,move,11.5,20,,,\n"
                                   "1,key,,,,Ctrl+Z,\n"
                                   "1,set,,,,method,coupled\n"
                                   "1,set,,,,opacity,0.5\n"
                                   "2,wheel,,,,,-1\n"
                                   "2,shot,,,,,picture.png\n"
                                   "3,resize,0,0,,,\n",
                                   "script.csv");
  ASSERT_EQ(script.size(), 8u);
  EXPECT_EQ(script[0].event.kind, EventKind::pointer_down);
  EXPECT_EQ(script[0].event.button, 1);
  EXPECT_EQ(script[1].event.x, 11.5);
  EXPECT_TRUE(script[2].event.control);
  EXPECT_EQ(script[2].event.name, "Z");
  EXPECT_EQ(script[3].event.text, "coupled");
  EXPECT_EQ(script[4].event.value, 0.5);
  EXPECT_EQ(script[5].event.value, -1);
  EXPECT_EQ(script[6].event.text, "picture.png");
  EXPECT_EQ(script[7].at, 3);
}

TEST(LiveScriptContract, EveryFaultIsNamedAtOnce) {
  const auto faults = maille::test::faults_found_by([] {
    parse_script("time [s],event,x,y,button,name,value\n-1,down,10,20,,,\n0,dance,1,2,,,\n"
                 "1,move,here,2,,,\n0.5,up,1,2,,,\n",
                 "script.csv");
  });
  ASSERT_EQ(faults.size(), 4u);
  const std::array<const char*, 4> keys{"", "event", "x", ""};
  for (int i = 0; i < 4; ++i)
    EXPECT_TRUE(maille::test::says(faults[std::size_t(i)], {.line = 2 + i, .key = keys[std::size_t(i)]}));
  EXPECT_THROW(parse_script("", "script.csv"), InputError);
  EXPECT_THROW(parse_script("time,event\n", "script.csv"), InputError);
}

} // namespace
} // namespace maille::live
