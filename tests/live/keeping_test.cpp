/// What a hand keeps of what it sees: screenshots, films, the distance from finite elements.

#include "live/by_hand.hpp"
#include "maille/deform/solve.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <fstream>

#include <sys/stat.h>

namespace maille::live {
namespace {
using test::world_folder;

ScriptedEvent key(const char* name, bool control = false) {
  Event event;
  event.kind = EventKind::key_down;
  event.name = name;
  event.control = control;
  return {0, event};
}

ScriptedEvent widget(const char* name, double value = 0) {
  Event event;
  event.kind = EventKind::widget;
  event.name = name;
  event.value = value;
  return {0, event};
}

ScriptedEvent pointer(EventKind kind, double x, double y, bool shift = false) {
  Event event;
  event.kind = kind;
  event.button = 1;
  event.x = x;
  event.y = y;
  event.shift = shift;
  return {0, event};
}

/// Width and height that a PNG says it has.
std::array<int, 2> size_of_png(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::array<unsigned char, 24> head{};
  in.read(reinterpret_cast<char*>(head.data()), head.size());
  if (!in || head[1] != 'P' || head[2] != 'N')
    return {0, 0};
  return {head[18] * 256 + head[19], head[22] * 256 + head[23]};
}

TEST(LiveKeepingContract, ScreenshotsAndFilmsAreFilesOfTheWindowsSize) {
  const maille::test::TemporaryFolder folder;
  HeadlessWindow window(200, 150);
  LiveSettings settings;
  settings.scene = world_folder / "maze.toml";
  settings.in_step = true;
  settings.shots = folder.path();
  Event shot;
  shot.kind = EventKind::shot;
  shot.text = "asked.png"; // in the folder of shots
  settings.script = {key("F12"), {0, shot}, widget("film"), key("Home"), key("Home"), widget("film")};
  LiveTools tools = test::tools();
  std::int64_t n_of_film = 0;
  tools.make_film = [&](const std::filesystem::path& stem, std::int64_t n, double seconds) {
    for (std::int64_t i = 0; i < n; ++i) {
      std::string number = std::to_string(i);
      number.insert(0, 4 - number.size(), '0');
      EXPECT_EQ(size_of_png(stem.string() + "_" + number + ".png"), (std::array{200, 150}));
    }
    EXPECT_GT(seconds, 0);
    n_of_film = n;
    return std::optional<std::string>{};
  };
  const LiveReport report = run_live(window, settings, tools);
  EXPECT_TRUE(report.messages.empty());
  EXPECT_EQ(size_of_png(folder.path() / "asked.png"), (std::array{200, 150}));
  EXPECT_EQ(size_of_png(folder.path() / "maille_001.png"), (std::array{200, 150}));
  EXPECT_GT(n_of_film, 0);
}

TEST(LiveKeepingContract, AFolderThatIsNotThereIsSaid) {
  HeadlessWindow window(200, 150);
  LiveSettings settings;
  settings.scene = world_folder / "maze.toml";
  settings.in_step = true;
  settings.shots = "/nobody/made/this";
  settings.script = {key("F12")};
  const LiveTools tools = test::tools();
  const LiveReport report = run_live(window, settings, tools);
  ASSERT_EQ(report.messages.size(), 1u);
  EXPECT_NE(report.messages[0].find("/nobody/made/this"), std::string::npos);
  EXPECT_TRUE(report.has_lost);
}

TEST(LiveKeepingContract, ScreenshotsStayInTheirFolderAndFollowNoLink) {
  const maille::test::TemporaryFolder folder;
  const auto precious = folder.path() / "precious.png", shots = folder.path() / "shots";
  std::filesystem::create_directory(shots);
  std::ofstream(precious) << "precious";
  std::filesystem::create_symlink(precious, shots / "link.png");
  std::filesystem::create_directory(shots / "folder.png");
  ASSERT_EQ(mkfifo((shots / "pipe.png").c_str(), 0600), 0);
  for (const std::string name : {"../precious.png", "link.png", "folder.png", "pipe.png", "notes.txt"}) {
    HeadlessWindow window(200, 150);
    LiveSettings settings;
    settings.scene = world_folder / "maze.toml";
    settings.in_step = true;
    settings.shots = shots;
    Event shot;
    shot.kind = EventKind::shot;
    shot.text = name;
    settings.script = {{0, shot}};
    const LiveReport report = run_live(window, settings, test::tools());
    EXPECT_TRUE(report.has_lost) << name;
    EXPECT_EQ(report.messages.size(), 1U) << name;
  }
  std::string text;
  std::ifstream(precious) >> text;
  EXPECT_EQ(text, "precious");
  EXPECT_TRUE(std::filesystem::is_symlink(shots / "link.png") &&
              std::filesystem::is_fifo(shots / "pipe.png"));
  EXPECT_THROW(parse_script("time [s],event,x,y,button,name,value\n0,shot,,,,,../w.png\n", "e.csv"),
               InputError);
}

/// A node of the block is pulled by limits and pinned; F asks for the truth, here `coupled` without limits.
LiveReport asked_for_truth(HeadlessWindow& window, std::vector<ScriptedEvent> then,
                           std::atomic<int>& n_asked) {
  LiveSettings settings;
  settings.scene = std::filesystem::path(MAILLE_SCENES) / "poke_given_limits.toml";
  settings.in_step = true;
  settings.script = {pointer(EventKind::pointer_down, 80, 60), pointer(EventKind::pointer_move, 84, 40),
                     pointer(EventKind::pointer_up, 84, 40, true), key("F")};
  settings.script.insert(settings.script.end(), then.begin(), then.end());
  LiveTools tools = test::tools();
  tools.finite_elements = [&](const Scene& question, const Control& control) {
    ++n_asked;
    Scene asked = question;
    asked.limits = {};
    return deform::solve(asked, "coupled", control);
  };
  return run_live(window, settings, tools);
}

bool says(const HeadlessWindow& window, const std::string& what) {
  return std::ranges::any_of(window.shown().texts, [&](const OverlayText& text) {
    return text.text.find(what) != std::string::npos;
  });
}

TEST(LiveKeepingContract, FiniteElementsAreAskedOnAKeyAndTheDifferenceIsSeen) {
  std::atomic<int> n_asked{0};
  HeadlessWindow window(160, 120);
  const LiveReport report = asked_for_truth(window, {}, n_asked);
  EXPECT_TRUE(report.messages.empty());
  EXPECT_EQ(n_asked, 1);
  EXPECT_TRUE(says(window, "% from finite elements"));
  ASSERT_NE(window.widget("colour"), nullptr);
  EXPECT_EQ(window.widget("colour")->value, static_cast<double>(ColourBy::fem));
  const bool has_scale = std::ranges::any_of(window.shown().panel, [](const Widget& each) {
    return each.label.starts_with("distance: 0 (dark) to");
  });
  EXPECT_TRUE(has_scale); // the body is coloured by it
}

TEST(LiveKeepingContract, ADifferenceIsNotShownOfAnotherState) {
  std::atomic<int> n_asked{0};
  HeadlessWindow window(160, 120);
  asked_for_truth(window, {key("Z", true)}, n_asked);
  EXPECT_EQ(n_asked, 1);
  EXPECT_FALSE(says(window, "% from finite elements"));
}

} // namespace
} // namespace maille::live
