/// `maille stability`, bounded.

#include "studies/commands/run_command.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <map>
#include <set>

namespace maille {
namespace {

using nlohmann::json;
using test::maille_command;
using test::Outcome;

std::map<std::string, json> checks_of(const json& result) {
  std::map<std::string, json> by_name;
  for (const json& check : result["checks"])
    by_name[check["name"]] = check;
  return by_name;
}

TEST(StabilityCommandContract, NoExtremeBreaksAPromise) {
  const Outcome run = maille_command("stability --quick --json");
  ASSERT_FALSE(run.out.empty()) << run.err;
  const json result = json::parse(run.out);
  std::map<std::string, std::set<std::string>> methods;
  for (const json& row : result["rows"]) {
    EXPECT_EQ(row["broken"], "") << row;
    methods[row["extreme"]].insert(row["method"]);
  }
  EXPECT_EQ(result["notes"], json::array()) << "random scenes that break a promise";
  EXPECT_EQ(run.code, 0);
  EXPECT_GE(methods.size(), 25u);
  for (const auto& [extreme, asked] : methods)
    EXPECT_TRUE(asked.size() == 7 || asked.contains("(reader)") || extreme.starts_with("worlds: "))
        << extreme << ": all but quadratic elements";
  // Truth: the names that were asked for.
  auto checks = checks_of(result);
  for (const char* name :
       {"cells_total", "cells_broken", "random_scenes", "random_scenes_broken", "random_worlds",
        "random_worlds_broken", "cyclic_drift_relaxed", "cyclic_drift_coupled"})
    EXPECT_TRUE(checks.contains(name)) << name;
  EXPECT_EQ(checks["random_scenes"]["goal"], 10000);
  EXPECT_EQ(checks["cells_total"]["value"], checks["cells_total"]["goal"]) << "every cell has an outcome";
}

TEST(StabilityCommandContract, CyclesOfTheRelaxersDoNotDrift) {
  const Outcome run = maille_command("stability --quick --only 'cyclic loading' --json");
  auto checks = checks_of(json::parse(run.out));
  // Truth: an answer depends on its scene alone, so the first and the last cycle are the same to the bit.
  EXPECT_EQ(checks["cyclic_drift_relaxed"]["value"], 0);
  EXPECT_EQ(checks["cyclic_drift_coupled"]["value"], 0);
}

TEST(StabilityCommandContract, OneExtremeCanBeAskedAndMakesAPage) {
  const test::TemporaryFolder folder;
  const std::string page = (folder / "page.md").string();
  const Outcome run = maille_command("stability --only 'a single cell' --markdown " + page);
  EXPECT_EQ(run.code, 0) << run.err;
  std::ifstream stream(page);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  EXPECT_NE(text.find("## a single cell"), std::string::npos);
  EXPECT_NE(text.find("| 3D, pulled | `fem_q2` | settled |"), std::string::npos);
  const Outcome wrong = maille_command("stability --only nothing");
  EXPECT_EQ(wrong.code, 2);
  EXPECT_NE(wrong.err.find("a single cell"), std::string::npos) << "names what there is";
}

} // namespace
} // namespace maille
