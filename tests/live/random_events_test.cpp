/// Random events: no crash, no penetration, a file that is read back.

#include "live/by_hand.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>

namespace maille::live {
namespace {

Event any_event(std::mt19937& random, int width, int height) {
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  static const std::vector<std::string> keys{"Left", "Right", "Up", "Down", ",",    ".", "P", "R", "Z",
                                             "Y",    "1",     "2",  "3",    "Home", "=", "-", "T"};
  static const std::vector<std::string> widgets{"patch",  "pin",    "release", "stiffness", "limits",
                                                "frame",  "undo",   "redo",    "colour",    "opacity",
                                                "stereo", "colour", "method",  "nobody",    "threshold"};
  Event event;
  event.x = below(width + 20) - 10;
  event.y = below(height + 20) - 10;
  event.button = 1 + (below(8) == 0 ? below(3) : 0);
  event.shift = below(4) == 0;
  switch (below(12)) {
  case 0:
  case 1:
    event.kind = EventKind::pointer_down;
    break;
  case 2:
    event.kind = EventKind::pointer_up;
    break;
  case 3:
    event.kind = EventKind::wheel;
    event.value = below(7) - 3;
    break;
  case 4:
    event.kind = EventKind::key_down;
    event.name = keys[static_cast<std::size_t>(below(static_cast<int>(keys.size())))];
    event.control = event.name == "Z" || event.name == "Y";
    break;
  case 5:
    event.kind = EventKind::widget;
    event.name = widgets[static_cast<std::size_t>(below(static_cast<int>(widgets.size())))];
    event.value = below(5) - 1;
    break;
  case 6:
    event.kind = below(10) == 0  ? EventKind::resize
                 : below(3) == 0 ? EventKind::stick_lost
                                 : EventKind::stick;
    event.x = below(3) * width / 2;
    event.y = below(3) * height / 2;
    if (event.kind == EventKind::stick) {
      event.name = below(2) == 0 ? "a" : "leftx";
      event.value = below(3) - 1;
    }
    break;
  default:
    event.kind = EventKind::pointer_move;
  }
  return event;
}

struct RandomCase {
  const char* scene;
  int n;                   ///< events, in a second or so
  double budget = 0;       ///< of a frame [s]; 0: until settled
  const char* method = ""; ///< in place of the scene's
};

class LiveRandomContract : public testing::TestWithParam<RandomCase> {};

/// MAILLE_LIVE_EVENTS: how many; docs/developers/live.md says how to have ten minutes of them.
TEST_P(LiveRandomContract, EventsOfAllKindsNeverCrashNorPenetrate) {
  const char* const asked = std::getenv("MAILLE_LIVE_EVENTS");
  const int n = asked != nullptr ? std::atoi(asked) : GetParam().n;
  const std::uint32_t seed = 20261124;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random(seed);
  HeadlessWindow window(200, 150);
  LiveSettings settings;
  settings.scene = std::filesystem::path(MAILLE_SCENES) / GetParam().scene;
  settings.in_step = true;
  settings.method = GetParam().method;
  if (GetParam().budget > 0)
    settings.frame_budget = GetParam().budget;
  settings.device = std::make_shared<GamePad>(0.01);
  for (int i = 0; i < n; ++i)
    settings.script.push_back({0, any_event(random, 200, 150)});
  Event size;
  size.kind = EventKind::resize;
  size.x = 200;
  size.y = 150;
  settings.script.push_back({0, size});
  const LiveTools tools = test::tools();
  const LiveReport report = run_live(window, settings, tools);
  EXPECT_EQ(report.penetrations, 0);
  EXPECT_EQ(report.events, n + 1);
}

INSTANTIATE_TEST_SUITE_P(Scenes, LiveRandomContract,
                         testing::Values(RandomCase{"world/maze.toml", 60},
                                         RandomCase{"world/puzzle.toml", 60},
                                         RandomCase{"poke_given_limits.toml", 60},
                                         RandomCase{"poke_given_limits.toml", 40, 0.005, "coupled"},
                                         RandomCase{"world/pressed.toml", 40, 0.005}),
                         [](const auto& each) {
                           const std::string name = std::filesystem::path(each.param.scene).stem();
                           return name + (*each.param.method != 0 ? "_" : "") + each.param.method;
                         });

} // namespace
} // namespace maille::live
