/// `maille probe` as outside scripts see it.

#include "studies/commands/command_scenes.hpp"
#include "studies/commands/run_command.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>

namespace maille {
namespace {

using nlohmann::json;
using test::maille_command;
using test::Outcome;

const std::string floor_and_pad = test::floor_pad_and_finger(R"(["3 mm", "3 mm", "10 mm"])");

// Analytic: 2 mm into the floor against 250 N/m.
TEST(ProbeCommandAnalytic, AFloorPushesBackByTheCoupling) {
  const test::TemporaryFolder folder;
  const auto scene = folder.write("floor.toml", floor_and_pad);
  const auto motion = folder.write(
      "down.csv", "time,x,y,z\n0,0.005,0.005,0.006\n0.2,0.005,0.005,0.002\n0.3,0.005,0.005,0.002\n");
  const Outcome run = maille_command(
      fmt::format("probe {} {} --stiffness 250 --no-clock --json", scene.string(), motion.string()));
  ASSERT_EQ(run.code, 0) << run.err;
  const json result = json::parse(run.out);
  EXPECT_NEAR(result["force"]["largest_n"], 250 * 2e-3, 1e-6);
  EXPECT_EQ(result["ticks"], 301);
  EXPECT_EQ(result["penetrations"], 0);
  EXPECT_EQ(result["missed_deadlines"], 0);
  std::int64_t sum = 0;
  for (const json& bin : result["latency"]["bins"])
    sum += bin["count"].get<std::int64_t>();
  EXPECT_EQ(sum, 301);
  // A tool of 2 mm stands on it a half cell sooner: its lowest centres are 0.5 mm below its middle.
  const Outcome tool = maille_command(fmt::format(
      "probe {} {} --tool finger --stiffness 250 --no-clock --json", scene.string(), motion.string()));
  ASSERT_EQ(tool.code, 0) << tool.err;
  EXPECT_NEAR(json::parse(tool.out)["force"]["largest_n"], 250 * 2.5e-3, 1e-6);
}

TEST(ProbeCommandContract, APadIsSofterThanTheFloorAndRunsRepeat) {
  const test::TemporaryFolder folder;
  const auto scene = folder.write("floor.toml", floor_and_pad);
  const auto motion = folder.write(
      "down.csv", "time,x,y,z\n0,0.013,0.010,0.014\n0.3,0.013,0.010,0.010\n0.5,0.0141,0.011,0.010\n");
  const std::string command = fmt::format("probe {} {} --radius 1mm --no-clock --picture {}", scene.string(),
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
  const Outcome run = maille_command(fmt::format("probe {} {} --tool probe --radius 3mm --no-clock --json",
                                                 (folder / "muscle.toml").string(),
                                                 (folder / "muscle_stroked.csv").string()));
  ASSERT_EQ(run.code, 0) << run.err;
  const json result = json::parse(run.out);
  EXPECT_EQ(result["penetrations"], 0);
  EXPECT_GT(result["force"]["touching_ticks"].get<int>(), 1000);
  EXPECT_LT(result["force"]["touching_ticks"].get<int>(), result["ticks"].get<int>()); // it comes and goes
  EXPECT_GT(result["force"]["largest_n"].get<double>(), 0.01);
}

TEST(ProbeCommandContract, InRealTimeItReportsLatencies) {
  const test::TemporaryFolder folder;
  const auto scene = folder.write("floor.toml", floor_and_pad);
  const auto motion = folder.write("down.csv", "time,x,y,z\n0,0.013,0.010,0.014\n0.3,0.013,0.010,0.010\n");
  const Outcome run = maille_command(fmt::format("probe {} {}", scene.string(), motion.string()));
  ASSERT_EQ(run.code, 0) << run.err;
  for (const char* word : {"force", "passivity", "latency", "missed deadlines", "99.9 %"})
    EXPECT_NE(run.out.find(word), std::string::npos) << run.out;
}

TEST(ProbeCommandContract, WrongUseIsExitCodeTwo) {
  const test::TemporaryFolder folder;
  const auto scene = folder.write("floor.toml", floor_and_pad);
  const auto motion = folder.write("down.csv", "time,x,y,z\n0,0.005,0.005,0.006\n");
  const auto inside = folder.write("inside.csv", "time,x,y,z\n0,0.005,0.005,0.001\n");
  const auto faulty = folder.write("faulty.csv", "time,x,y,z\n0,0,0\n");
  const std::string both = scene.string() + " " + motion.string();
  for (const auto& [arguments, words] :
       {std::pair{both + " --stiffness 2000", "--stiffness: expected less than 1000 N/m"},
        std::pair{both + " --tool pad", "--tool: expected the name of a rigid object"},
        std::pair{both + " --radius wide", "--radius: expected"},
        std::pair{scene.string() + " " + inside.string(), "free space"},
        std::pair{scene.string() + " " + faulty.string(), "faulty.csv:2"}}) {
    const Outcome run = maille_command("probe " + arguments);
    EXPECT_EQ(run.code, 2) << arguments;
    EXPECT_NE(run.err.find(words), std::string::npos) << run.err;
  }
}

} // namespace
} // namespace maille
