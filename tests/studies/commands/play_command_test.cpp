/// `maille play` as outside scripts see it: files, formats, exit codes.

#include "studies/commands/command_scenes.hpp"
#include "studies/commands/run_command.hpp"
#include "support/kit.hpp"

#include <nlohmann/json.hpp>

namespace maille {
namespace {

using nlohmann::json;

using test::maille_command;
using test::Outcome;

const std::string box_and_wall =
    test::world_text("[12, 8]") + test::object_text("wall", "fixed", "[1, 8]", "position = [\"9 mm\", 0]\n") +
    test::object_text("a box", "rigid", "[2, 2]", "position = [\"2 mm\", \"3 mm\"]\n");

const char* const pushed = R"(frame_time = "100 ms"
[[drive]]
object = "a box"
by = ["10 mm", 0]
frames = 5
)";

struct Folder : test::TemporaryFolder {
  std::string files = write("box.toml", box_and_wall).string() + " " + write("pushed.toml", pushed).string();
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
  const Outcome run = test::done("play " + folder.files + " --no-pictures --out " + folder.out());
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
  const json result = test::json_of("play " + folder.files + " --json");
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
  const Outcome run = test::done("play " + folder.files + " --out " + folder.out() + " --picture " +
                                 folder.out() + "/overview.png");
  if (run.out.find("no picture") != std::string::npos)
    GTEST_SKIP() << run.out;
  EXPECT_EQ(folder.names(".png").size(), 6u + 1u);
  // A film where there is ffmpeg, else a word about it.
  EXPECT_NE(folder.names(".mp4").empty(), run.out.find("no film") == std::string::npos) << run.out;
}

TEST(PlayCommandContract, AShorterPlayLeavesNothingOfALongerOne) {
  const Folder folder;
  test::done("play " + folder.files + " --out " + folder.out());
  std::string text(pushed);
  text.replace(text.find("frames = 5"), 10, "frames = 2");
  const std::string shorter = folder.write("shorter.toml", text).string();
  const Outcome run =
      test::done("play " + (folder / "box.toml").string() + " " + shorter + " --out " + folder.out());
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
  const Outcome trajectory = test::refused("play " + box + " " + bad.string());
  EXPECT_TRUE(test::has(trajectory.err, "bad.toml:2: drive[1].object"));
  EXPECT_TRUE(test::has(trajectory.err, "bad.toml:4: drive[1].speed"));
  test::refused("play " + box);
  test::refused("play " + box + " " + (folder / "none.toml").string());
  test::refused("play " + folder.files + " --picture " + (folder / "a.jpg").string());
  test::refused("run " + box);
}

TEST(PlayCommandContract, ObjectsThatOverlapAreAFaultOfTheScene) {
  const Folder folder;
  std::string text = box_and_wall;
  text.replace(text.find("\"2 mm\", \"3 mm\""), 14, "\"8 mm\", \"3 mm\"");
  const auto file = folder.write("overlap.toml", text);
  for (const std::string command : {"check", "check --why"}) {
    const Outcome run = test::refused(command + " " + file.string());
    EXPECT_TRUE(test::has(run.err, "a box"));
  }
}

TEST(PlayCommandContract, CheckAndExplainKnowWorlds) {
  const Folder folder;
  const std::string box = (folder / "box.toml").string();
  const Outcome check = test::done("check " + box);
  EXPECT_TRUE(test::has(check.out, "2D world of 12 x 8 cells, 1 fixed, 1 rigid, 0 deformable objects"));
  const Outcome explain = test::done("check --why " + box + " --json");
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
  EXPECT_EQ(run.code, 128 + 2) << run.err;
  const std::string pvd = folder.text("box.pvd");
  EXPECT_TRUE(test::has(pvd, "</VTKFile>"));
  EXPECT_GT(count(pvd, "<DataSet"), 2u);
  const std::size_t last = pvd.rfind("file=\"") + 6;
  EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(folder.out()) /
                                      pvd.substr(last, pvd.find('"', last) - last)));
}

/// `maille play` of a hand as outside scripts see it.

const std::string floor_and_pad = test::floor_pad_and_finger(R"(["3 mm", "3 mm", "10 mm"])");

// Analytic: 2 mm into the floor against 250 N/m.
TEST(ProbeCommandAnalytic, AFloorPushesBackByTheCoupling) {
  const test::TemporaryFolder folder;
  const auto scene = folder.write("floor.toml", floor_and_pad);
  const auto motion = folder.write(
      "down.csv", "time,x,y,z\n0,0.005,0.005,0.006\n0.2,0.005,0.005,0.002\n0.3,0.005,0.005,0.002\n");
  const json result = test::json_of(
      fmt::format("play {} {} --stiffness 250 --no-clock --json", scene.string(), motion.string()));
  EXPECT_NEAR(result["force"]["largest_n"], 250 * 2e-3, 1e-6);
  EXPECT_EQ(result["ticks"], 301);
  EXPECT_EQ(result["penetrations"], 0);
  EXPECT_EQ(result["missed_deadlines"], 0);
  std::int64_t sum = 0;
  for (const json& bin : result["latency"]["bins"])
    sum += bin["count"].get<std::int64_t>();
  EXPECT_EQ(sum, 301);
  // A tool of 2 mm stands on it a half cell sooner: its lowest centres are 0.5 mm below its middle.
  const Outcome tool = test::done(fmt::format("play {} {} --tool finger --stiffness 250 --no-clock --json",
                                              scene.string(), motion.string()));
  EXPECT_NEAR(json::parse(tool.out)["force"]["largest_n"], 250 * 2.5e-3, 1e-6);
}

TEST(ProbeCommandContract, APadIsSofterThanTheFloorAndRunsRepeat) {
  const test::TemporaryFolder folder;
  const auto scene = folder.write("floor.toml", floor_and_pad);
  const auto motion = folder.write(
      "down.csv", "time,x,y,z\n0,0.013,0.010,0.014\n0.3,0.013,0.010,0.010\n0.5,0.0141,0.011,0.010\n");
  const std::string command = fmt::format("play {} {} --radius 1mm --no-clock --picture {}", scene.string(),
                                          motion.string(), (folder / "p.svg").string());
  const Outcome run = maille_command(command + " --csv -"), again = maille_command(command + " --csv -");
  ASSERT_EQ(run.code, 0) << run.err;
  const auto without_latency = [](const std::string& csv) {
    std::string text;
    for (std::size_t begin = 0, end; begin < csv.size(); begin = end + 1) {
      end = csv.find('\n', begin);
      const std::string line = csv.substr(begin, end - begin);
      const std::size_t time = line.find(','), latency = line.rfind(',');
      text += line.substr(time, latency - time) + "\n";
    }
    return text;
  };
  EXPECT_EQ(without_latency(run.out), without_latency(again.out));
  EXPECT_TRUE(std::filesystem::exists(folder / "p.svg"));
  const Outcome numbers = maille_command(command + " --json");
  const json result = json::parse(numbers.out);
  EXPECT_GT(result["force"]["largest_n"], 0);
  EXPECT_LT(result["force"]["largest_n"], 0.5 * 300 * 1e-3); // the floor's would be the coupling's
  EXPECT_GT(result["bodies"]["answers"], 1);
  EXPECT_EQ(result["penetrations"], 0);
  EXPECT_GE(result["passivity"]["least_energy_j"], -1e-9);
}

// The command that docs/probe.md begins with.
TEST(ProbeCommandContract, TheStrokeOverAMuscleIsFelt) {
  const std::filesystem::path folder = std::filesystem::path(MAILLE_SCENES) / "world";
  const json result =
      test::json_of(fmt::format("play {} {} --tool probe --radius 3mm --no-clock --json",
                                (folder / "muscle.toml").string(), (folder / "muscle_stroked.csv").string()));
  EXPECT_EQ(result["penetrations"], 0);
  EXPECT_GT(result["force"]["touching_ticks"].get<int>(), 1000);
  EXPECT_LT(result["force"]["touching_ticks"].get<int>(), result["ticks"].get<int>()); // it comes and goes
  EXPECT_GT(result["force"]["largest_n"].get<double>(), 0.01);
}

TEST(ProbeCommandContract, InRealTimeItReportsLatencies) {
  const test::TemporaryFolder folder;
  const auto scene = folder.write("floor.toml", floor_and_pad);
  const auto motion = folder.write("down.csv", "time,x,y,z\n0,0.013,0.010,0.014\n0.3,0.013,0.010,0.010\n");
  const Outcome run = test::done(fmt::format("play {} {}", scene.string(), motion.string()));
  for (const char* word : {"force", "passivity", "latency", "missed deadlines", "99.9 %"})
    EXPECT_TRUE(test::has(run.out, word));
}

TEST(ProbeCommandContract, WrongUseIsExitCodeTwo) {
  const test::TemporaryFolder folder;
  const auto scene = folder.write("floor.toml", floor_and_pad);
  const auto motion = folder.write("down.csv", "time,x,y,z\n0,0.005,0.005,0.006\n");
  const auto inside = folder.write("inside.csv", "time,x,y,z\n0,0.005,0.005,0.001\n");
  const auto faulty = folder.write("faulty.csv", "time,x,y,z\n0,0,0\n");
  const std::string both = scene.string() + " " + motion.string();
  test::expect_refused({{"play " + both + " --stiffness 2000", "--stiffness: expected less than 1000 N/m"},
                        {"play " + both + " --tool pad", "--tool"},
                        {"play " + both + " --radius wide", "--radius"},
                        {"play " + scene.string() + " " + inside.string(), "free space"},
                        {"play " + scene.string() + " " + faulty.string(), "faulty.csv:2"}});
}

} // namespace
} // namespace maille
