/// The window's whole way, from events to pictures, without a screen.

#include "live/by_hand.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

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

/// Where the frame of an object is at the end of a recorded trajectory.
deform::Pose end_of(const std::string& trajectory, WorldScene scene, std::size_t object) {
  const Trajectory read = parse_trajectory(trajectory, "hand.csv", scene);
  deform::World world(scene);
  deform::TrajectoryDrives drives(world);
  for (std::int64_t frame = 1; frame <= read.n_frames; ++frame) {
    std::vector<DriveSpan> spans;
    for (const DriveSpan& span : read.spans)
      if (span.first_frame == frame)
        spans.push_back(span);
    world.advance(drives.begin_frame(world, spans, frame));
  }
  return drives.frame_now(world, object);
}

TEST(LiveAppContract, TheMazeIsWalkedByThePointer) {
  const WorldScene scene = read_world_scene(world_folder / "maze.toml");
  HeadlessWindow window(640, 480);
  // The piece begins at (2, 2); it is taken in a cell of its own, the lower left one of its middle row.
  const LiveReport report = played(world_folder / "maze.toml",
                                   dragged(scene, {4.5 * mm, 4.5 * mm},
                                           in_metres({{2, 28.5},
                                                      {20.5, 26},
                                                      {18, 15.5},
                                                      {7.5, 18},
                                                      {10, 7.5},
                                                      {20.5, 10},
                                                      {18, -0.5},
                                                      {44.5, 2},
                                                      {42, 12.5},
                                                      {23.5, 10},
                                                      {26, 20.5},
                                                      {60.5, 18},
                                                      {58, 28.5},
                                                      {47.5, 26},
                                                      {50, 36.5},
                                                      {39.5, 34},
                                                      {42, 44.5},
                                                      {60.5, 42}},
                                                     2, 2)),
                                   window);
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
  settings.in_step = true;
  Event choose;
  choose.kind = EventKind::widget;
  choose.name = "open maze";
  Event back = choose;
  back.name = "menu";
  settings.script = {{0, choose}, {0, back}};
  const LiveTools tools = test::tools();
  const LiveReport report = run_live(window, settings, tools);
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
  Event key;
  key.kind = EventKind::key_down;
  key.name = "F1";
  for (const char* file : {"eight.toml", "chain.toml", "puzzle.toml"}) {
    HeadlessWindow window(320, 240);
    (void)played(world_folder / file, {{0, Event()}}, window);
    EXPECT_TRUE(says(window, "Drag")) << file;
    EXPECT_FALSE(says(window, "Ctrl+Q"));
    (void)played(world_folder / file, {{0, key}}, window);
    EXPECT_TRUE(says(window, "Ctrl+Q")) << file;
    (void)played(world_folder / file, {{0, key}, {0, key}}, window);
    EXPECT_FALSE(says(window, "Ctrl+Q")) << file;
  }
}

TEST(LiveAppContract, FaultsOfASceneAreShownAllOfThem) {
  const auto file = std::filesystem::path(testing::TempDir()) / "live_faulty.toml";
  std::ofstream(file)
      << "[world]\ncells = [8, 8]\nspacing = \"-1 mm\"\n[[object]]\nname = \"a\"\nkind = \"soft\"\n";
  HeadlessWindow window(320, 240);
  Event nothing;
  const LiveReport report = played(file, {{0, nothing}}, window);
  EXPECT_GE(report.messages.size(), 2u);
  std::size_t shown = 0;
  for (const Widget& widget : window.shown().panel)
    shown += widget.emphasis;
  EXPECT_EQ(shown, report.messages.size());
  std::filesystem::remove(file);
}

TEST(LiveAppContract, MethodsAreSwitchedAndToldApart) {
  HeadlessWindow window(160, 120);
  LiveSettings settings;
  settings.scene = std::filesystem::path(MAILLE_SCENES) / "poke_given_limits.toml";
  settings.in_step = true;
  const auto key = [](const char* name) {
    Event event;
    event.kind = EventKind::key_down;
    event.name = name;
    return ScriptedEvent{0, event};
  };
  Event down, move, up;
  down.kind = EventKind::pointer_down;
  down.button = 1;
  down.x = 80;
  down.y = 60;
  move.kind = EventKind::pointer_move;
  move.x = 84;
  move.y = 50;
  up = move;
  up.kind = EventKind::pointer_up;
  up.button = 1;
  up.shift = true; // pinned
  settings.script = {{0, down}, {0, move}, {0, up}, key("2"), key("3"), key("1"), key("3")};
  const LiveTools tools = test::tools();
  const LiveReport report = run_live(window, settings, tools);
  EXPECT_TRUE(report.messages.empty()) << report.messages.front();
  EXPECT_NE(report.trajectory.find("method"), std::string::npos);
  EXPECT_NE(report.trajectory.find("body"), std::string::npos) << "nothing was taken: " << report.trajectory;
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
    Event resize;
    resize.kind = EventKind::resize;
    resize.x = width;
    resize.y = height;
    script.push_back({0, resize});
    Event click;
    click.kind = EventKind::pointer_down;
    click.button = 1;
    script.push_back({0, click});
    click.kind = EventKind::pointer_up;
    script.push_back({0, click});
  }
  const LiveReport report = played(world_folder / "maze.toml", script, window);
  EXPECT_EQ(report.events, 15);
}

TEST(LiveAppContract, ClosedInMidDragNothingIsLost) {
  const WorldScene scene = read_world_scene(world_folder / "maze.toml");
  const auto file = std::filesystem::path(testing::TempDir()) / "live_mid_drag.csv";
  HeadlessWindow window(640, 480);
  LiveSettings settings;
  settings.scene = world_folder / "maze.toml";
  settings.record = file;
  settings.in_step = true;
  settings.script = dragged(scene, {4.5 * mm, 4.5 * mm}, {{0, 20 * mm}});
  settings.script.back().event = {};
  settings.script.back().event.kind = EventKind::close; // in place of letting go
  const LiveTools tools = test::tools();
  const LiveReport report = run_live(window, settings, tools);
  const std::string text = maille::test::text_of(file);
  EXPECT_EQ(text, report.trajectory);
  EXPECT_NEAR(end_of(text, scene, 1).position[1], 22 * mm, 1e-3 * mm);
  std::filesystem::remove(file);
}

} // namespace
} // namespace maille::live
