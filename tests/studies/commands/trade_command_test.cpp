/// `maille trade` and `maille choose` as outside scripts see them.

#include "studies/commands/run_command.hpp"
#include "support/sanitized.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <set>

namespace maille {
namespace {

using nlohmann::json;
using test::maille_command;
using test::Outcome;

class TradeCommandContract : public testing::Test {
protected:
  test::TemporaryFolder folder;
  std::string scene =
      folder
          .write(
              "bent.toml",
              "title = \"a bar that is bent\"\n[specimen]\nshape = \"box\"\ncells = [8, 4, 4]\nspacing = "
              "\"1 mm\"\nmaterial = { youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }\n[[hold]]\nwhere = "
              "\"x-\"\n[[move]]\nwhere = \"x+\"\nby = [0, 0, \"0.5 mm\"]\n")
          .string();
  std::string small = "trade " + scene +
                      " --methods limits,coupled,fem_q1 --spacings 4,2,1 --tolerances 0.01 "
                      "--reference-seconds 3 --repetitions 1 ";
};

TEST_F(TradeCommandContract, WritesTablesAndPicturesWhole) {
  const Outcome run = maille_command(small + "--out " + (folder / "out").string());
  ASSERT_EQ(run.code, 0) << run.err;
  const json result = json::parse(test::text_of(folder / "out/bent_trade.json"));
  EXPECT_EQ(result["rows"].size(), 9u);
  for (const json& row : result["rows"]) {
    EXPECT_EQ(row["status"], "done");
    for (const char* key : {"method", "spacing_factor", "tolerance", "seconds", "bytes", "error", "on_front"})
      EXPECT_TRUE(row.contains(key)) << key;
  }
  EXPECT_EQ(result["whole"], true);
  const std::string csv = test::text_of(folder / "out/bent_trade.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 10);
  if (std::system("command -v gnuplot > /dev/null 2>&1") == 0) {
    EXPECT_EQ(test::text_of(folder / "out/bent_trade.png").substr(1, 3), "PNG");
    const std::string svg = test::text_of(folder / "out/bent_trade.svg");
    EXPECT_NE(svg.find("a bar that is bent"), std::string::npos);
    EXPECT_NE(svg.find("</svg>"), std::string::npos);
  }
  int n_files = 0;
  for (const auto& file : std::filesystem::directory_iterator(folder / "out"))
    n_files += file.is_regular_file();
  EXPECT_LE(n_files, 4) << "nothing half done is left";
}

TEST_F(TradeCommandContract, ItsTableIsWhatChooseReads) {
  const std::string table = (folder / "t.csv").string();
  ASSERT_EQ(maille_command(small + "--csv " + table).code, 0);
  // One scene alone can promise at a level of one half and no more.
  const Outcome half =
      maille_command("choose " + scene + " --error 200% --time 1min --level 50% --json --table " + table);
  ASSERT_EQ(half.code, 0) << half.err << half.out;
  EXPECT_FALSE(json::parse(half.out)["chosen"].is_null());
  EXPECT_EQ(maille_command("choose " + scene + " --error 200% --time 1min --table " + table).code, 1);
}

TEST_F(TradeCommandContract, ChooseSaysWhatMeetsTheWishOrThatNoneDoes) {
  const Outcome run = maille_command("choose " + scene + " --error 30% --time 10s --memory 1GiB --json");
  ASSERT_EQ(run.code, 0) << run.err;
  const json result = json::parse(run.out);
  const json& chosen = result["chosen"];
  EXPECT_LE(chosen["error"]["high"], 0.3);
  EXPECT_LE(chosen["seconds"]["high"], 10);
  EXPECT_LE(chosen["error"]["low"], chosen["error"]["expected"]);
  EXPECT_EQ(result["wish"]["bytes"], 1073741824);
  const Outcome none = maille_command("choose " + scene + " --error 0.0001% --time 16ms");
  EXPECT_EQ(none.code, 1);
  EXPECT_NE(none.out.find("none is expected to meet that"), std::string::npos) << none.out;
  EXPECT_NE(none.out.find("the most exact in that time"), std::string::npos) << none.out;
  const Outcome small_memory = maille_command("choose " + scene + " --error 30% --time 10s --memory 1kB");
  EXPECT_EQ(small_memory.code, 1);
}

TEST_F(TradeCommandContract, AnInterruptLeavesWhatIsThere) {
  const std::string large =
      folder
          .write("large.toml", "[specimen]\nshape = \"box\"\ncells = [96, 96, 96]\nspacing = \"1 mm\"\n"
                               "material = \"muscle/soleus\"\n[[hold]]\nwhere = \"x-\"\n[[move]]\n"
                               "where = \"x+\"\nby = [0, 0, \"1 mm\"]\n")
          .string();
  const Outcome run =
      test::shell("timeout --preserve-status -s INT -k 60 4 " + std::string(MAILLE_COMMAND) + " trade " +
                  large + " --methods limits,sweep --reference relaxed --repetitions 100 --json");
  ASSERT_EQ(run.code, 1) << run.err;
  EXPECT_EQ(json::parse(run.out)["whole"], false);
}

TEST_F(TradeCommandContract, WrongUseIsExitCodeTwoAndSaysWhat) {
  const std::string bad = folder.write("bad.csv", "a,b\n1,2\n").string(),
                    faulty = folder.write("faulty.toml", "[specimen]\nshape = 3\n").string();
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"trade", "SCENE"},
      {"trade none.toml", "none.toml"},
      {"trade " + faulty, "specimen.shape"},
      {"trade " + scene + " --methods magic", "magic"},
      {"trade " + scene + " --reference magic", "magic"},
      {"trade " + scene + " --spacings 3", "--spacings"},
      {"trade " + scene + " --tolerances 2", "--tolerances"},
      {"trade " + scene + " --repetitions 0", "--repetitions"},
      {"trade " + scene + " --csv - --json", "--csv"},
      {"trade " + scene + " --json /none/x.json", "--json"},
      {"choose " + scene, "--error"},
      {"choose " + scene + " --error 5% --time soon", "--time"},
      {"choose " + scene + " --error much --time 16ms", "--error"},
      {"choose " + scene + " --error -5% --time 16ms", "--error"},
      {"choose " + scene + " --error 5% --time 16ms --memory 1stone", "--memory"},
      {"choose " + scene + " --error 5% --time 16ms --level 100%", "--level"},
      {"choose " + scene + " --error 5% --time 16ms --table none.csv", "none.csv"},
      {"choose " + scene + " --error 5% --time 16ms --table " + bad, "bad.csv:1: method"},
      {"choose none.toml --error 5% --time 16ms", "none.toml"}};
  for (const auto& [arguments, text] : wrong) {
    const Outcome run = maille_command(arguments);
    EXPECT_EQ(run.code, 2) << arguments;
    EXPECT_NE(run.err.find(text), std::string::npos) << arguments << ": " << run.err;
  }
}

} // namespace
} // namespace maille
