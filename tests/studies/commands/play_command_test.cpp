/// `maille play` as outside scripts see it: files, formats, exit codes.

#include "studies/commands/run_command.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace maille {
namespace {

using nlohmann::json;

using test::maille_command;
using test::Outcome;

const char* const scene = R"(title = "a box is pushed to a wall"
[world]
cells = [12, 8]
spacing = "1 mm"
[[object]]
name = "wall"
kind = "fixed"
shape = "box"
cells = [1, 8]
position = ["9 mm", 0]
[[object]]
name = "a box"
kind = "rigid"
shape = "box"
cells = [2, 2]
position = ["2 mm", "3 mm"]
)";

const char* const pushed = R"(frame_time = "100 ms"
[[drive]]
object = "a box"
by = ["10 mm", 0]
frames = 5
)";

struct Folder : test::TemporaryFolder {
  std::string files = write("box.toml", scene).string() + " " + write("pushed.toml", pushed).string();
  std::string out() const { return path().string() + "/out"; }
  std::vector<std::string> names(const std::string& ending) const {
    std::vector<std::string> found;
    for (const auto& entry : std::filesystem::directory_iterator(out()))
      if (entry.path().extension() == ending)
        found.push_back(entry.path().filename().string());
    std::ranges::sort(found);
    return found;
  }
  std::string text(const std::string& name) const {
    return test::text_of(std::filesystem::path(out()) / name);
  }
};

std::size_t count(const std::string& text, const std::string& word) {
  std::size_t n = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1))
    ++n;
  return n;
}

TEST(PlayCommandContract, WritesATimeStepAFrameAndAWallOnce) {
  const Folder folder;
  const Outcome run = maille_command("play " + folder.files + " --no-pictures --out " + folder.out());
  ASSERT_EQ(run.code, 0) << run.err;
  const std::string pvd = folder.text("box.pvd");
  EXPECT_EQ(count(pvd, "<DataSet"), 2u * 6u); // frame 0 and five frames, two objects each
  EXPECT_EQ(count(pvd, "timestep=\"0.5\""), 2u);
  EXPECT_EQ(count(pvd, "box_wall_0000.vtu"), 6u);
  // In the third frame the box comes to the wall, and stays.
  EXPECT_EQ(folder.names(".vtu"),
            (std::vector<std::string>{"box_a_box_0000.vtu", "box_a_box_0001.vtu", "box_a_box_0002.vtu",
                                      "box_a_box_0003.vtu", "box_wall_0000.vtu"}));
  EXPECT_TRUE(folder.names(".png").empty());
}

TEST(PlayCommandContract, JsonSaysWhatBecameOfEveryFrame) {
  const Folder folder;
  const Outcome run = maille_command("play " + folder.files + " --json");
  ASSERT_EQ(run.code, 0) << run.err;
  const json result = json::parse(run.out);
  EXPECT_EQ(result["scene"], "box");
  EXPECT_EQ(result["trajectory"], "pushed");
  EXPECT_EQ(result["penetrations"], 0);
  EXPECT_EQ(result["objects"][1]["name"], "a box");
  EXPECT_NEAR(result["objects"][1]["position"][0].get<double>(), 7.5e-3, 1e-9);
  ASSERT_EQ(result["frames"].size(), 5u);
  EXPECT_EQ(result["frames"][1]["status"], "done");
  EXPECT_EQ(result["frames"][2]["status"], "clamped");
  // Voxels are the points at their centres: those stop where the wall's cell begins, 5.5 mm on.
  EXPECT_NEAR(result["frames"][2]["drives"][0]["fraction"], 0.75, 1e-6);
  EXPECT_LT(result["frames"][4]["drives"][0]["fraction"], 1e-6);
  const json& contact = result["frames"][4]["contacts"][0];
  EXPECT_EQ(contact["object"], "a box");
  EXPECT_EQ(contact["other"], "wall");
  EXPECT_EQ(contact["voxels"], 2);
}

TEST(PlayCommandContract, DrawsPicturesWhereItCan) {
  const Folder folder;
  const Outcome run = maille_command("play " + folder.files + " --out " + folder.out() + " --picture " +
                                     folder.out() + "/overview.png");
  ASSERT_EQ(run.code, 0) << run.err;
  if (run.out.find("no picture") != std::string::npos)
    GTEST_SKIP() << run.out;
  EXPECT_EQ(folder.names(".png").size(), 6u + 1u);
  // A film where there is ffmpeg, else a word about it.
  EXPECT_NE(folder.names(".mp4").empty(), run.out.find("no film") == std::string::npos) << run.out;
}

TEST(PlayCommandContract, AShorterPlayLeavesNothingOfALongerOne) {
  const Folder folder;
  ASSERT_EQ(maille_command("play " + folder.files + " --out " + folder.out()).code, 0);
  std::string text(pushed);
  text.replace(text.find("frames = 5"), 10, "frames = 2");
  const std::string shorter = folder.write("shorter.toml", text).string();
  const Outcome run =
      maille_command("play " + (folder / "box.toml").string() + " " + shorter + " --out " + folder.out());
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(folder.names(".vtu"), (std::vector<std::string>{"box_a_box_0000.vtu", "box_a_box_0001.vtu",
                                                            "box_a_box_0002.vtu", "box_wall_0000.vtu"}));
  if (run.out.find("no picture") != std::string::npos)
    GTEST_SKIP() << run.out;
  EXPECT_EQ(folder.names(".png").size(), 3u);
  if (folder.names(".mp4").empty())
    return; // no ffmpeg
  const Outcome frames = test::shell("ffprobe -v error -count_packets -select_streams v -show_entries "
                                     "stream=nb_read_packets -of csv=p=0 " +
                                     folder.out() + "/box.mp4");
  if (frames.code == 0) {
    EXPECT_EQ(std::atoi(frames.out.c_str()), 3) << frames.out;
  }
}

TEST(PlayCommandContract, FaultsOfSceneAndTrajectoryAreExitCodeTwo) {
  const Folder folder;
  const auto bad = folder.write("bad.toml", "[[drive]]\nobject = \"wall\"\nby = [1, 0]\nspeed = 3\n");
  const std::string box = (folder / "box.toml").string();
  const Outcome trajectory = maille_command("play " + box + " " + bad.string());
  EXPECT_EQ(trajectory.code, 2);
  EXPECT_NE(trajectory.err.find("bad.toml:2: drive[1].object"), std::string::npos) << trajectory.err;
  EXPECT_NE(trajectory.err.find("bad.toml:4: drive[1].speed"), std::string::npos) << trajectory.err;
  EXPECT_EQ(maille_command("play " + box).code, 2);
  EXPECT_EQ(maille_command("play " + box + " " + (folder / "none.toml").string()).code, 2);
  EXPECT_EQ(maille_command("play " + folder.files + " --picture " + (folder / "a.jpg").string()).code, 2);
  EXPECT_EQ(maille_command("run " + box).code, 2);
}

TEST(PlayCommandContract, ObjectsThatOverlapAreAFaultOfTheScene) {
  const Folder folder;
  std::string text = scene;
  text.replace(text.find("\"2 mm\", \"3 mm\""), 14, "\"8 mm\", \"3 mm\"");
  const auto file = folder.write("overlap.toml", text);
  for (const std::string command : {"check", "explain"}) {
    const Outcome run = maille_command(command + " " + file.string());
    EXPECT_EQ(run.code, 2) << command;
    EXPECT_NE(run.err.find("a box"), std::string::npos) << run.err;
  }
}

TEST(PlayCommandContract, CheckAndExplainKnowWorlds) {
  const Folder folder;
  const std::string box = (folder / "box.toml").string();
  const Outcome check = maille_command("check " + box);
  EXPECT_EQ(check.code, 0) << check.err;
  EXPECT_NE(check.out.find("2D world of 12 x 8 cells, 1 fixed, 1 rigid, 0 deformable objects"),
            std::string::npos)
      << check.out;
  const Outcome explain = maille_command("explain " + box + " --json");
  ASSERT_EQ(explain.code, 0) << explain.err;
  const json result = json::parse(explain.out);
  EXPECT_EQ(result["parts"][1]["name"], "deformable objects");
  EXPECT_FALSE(result["parts"][1]["on"]);
  EXPECT_GT(result["memory"]["map"], 0);
}

TEST(PlayCommandContract, InterruptLeavesAListThatCanBeOpened) {
  const Folder folder;
  const auto endless = folder.write(
      "endless.toml", "[[drive]]\nobject = \"a box\"\nturn = { angle = \"36000 deg\" }\nframes = 100000\n");
  const Outcome run = test::shell("timeout --preserve-status -s INT -k 60 8 " + std::string(MAILLE_COMMAND) +
                                  " play " + (folder / "box.toml").string() + " " + endless.string() +
                                  " --no-pictures --out " + folder.out());
  EXPECT_EQ(run.code, 1) << run.err;
  const std::string pvd = folder.text("box.pvd");
  EXPECT_NE(pvd.find("</VTKFile>"), std::string::npos);
  EXPECT_GT(count(pvd, "<DataSet"), 2u);
  const std::size_t last = pvd.rfind("file=\"") + 6;
  EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(folder.out()) /
                                      pvd.substr(last, pvd.find('"', last) - last)));
}

} // namespace
} // namespace maille
