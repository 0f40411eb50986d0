/// `maille bench` and `maille verify` as outside scripts see them.

#include "studies/run_command.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>

namespace maille {
namespace {

using nlohmann::json;
using test::maille_command;
using test::Outcome;

TEST(BenchCommandContract, ReportsMachineRowsAndChecks) {
  const Outcome run = maille_command("bench propagate --quick --json");
  ASSERT_EQ(run.code, 0) << run.err;
  const json result = json::parse(run.out);
  EXPECT_GT(result["machine"]["copy_gb_per_s"], 0);
  EXPECT_EQ(result["rows"].size(), 2u + 1u + 1u + 1u + 4u)
      << "whole bodies, a local drag, many handles, rounding, four hard bodies";
  for (const json& check : result["checks"])
    for (const char* key : {"name", "value", "goal", "met"})
      EXPECT_TRUE(check.contains(key)) << check;
}

TEST(VerifyCommandContract, ReportsEveryProblemAndWritesThePage) {
  const test::TemporaryFolder folder;
  const Outcome run = maille_command("verify --quick --json --markdown " + (folder / "page.md").string());
  ASSERT_EQ(run.code, 0) << run.out << run.err;
  const json result = json::parse(run.out);
  EXPECT_EQ(result["checks"][0]["name"], "verify_missed");
  EXPECT_EQ(result["checks"][0]["value"], 0);
  for (const json& row : result["rows"])
    for (const char* key :
         {"problem", "method", "quantity", "expected", "computed", "error", "tolerance", "met", "source"})
      EXPECT_TRUE(row.contains(key)) << row;
  std::ifstream page(folder / "page.md");
  const std::string text(std::istreambuf_iterator<char>(page), {});
  EXPECT_NE(text.find("| slender cantilever"), std::string::npos);
}

TEST(VerifyCommandContract, AMissedProblemIsExitCodeThree) {
  const test::TemporaryFolder folder; // a CalculiX that fails misses every problem that it is asked
  const auto script = folder.write("ccx", "#!/bin/sh\necho ' *ERROR: out of order'\n");
  std::filesystem::permissions(script, std::filesystem::perms::owner_all);
  const Outcome run =
      test::shell("PATH=" + folder.path().string() + ":$PATH " + MAILLE_COMMAND + " verify --quick --json");
  EXPECT_EQ(run.code, 3) << run.err;
  EXPECT_FALSE(json::parse(run.out)["checks"][0]["met"]);
}

} // namespace
} // namespace maille
