/// `maille bench` and `maille verify` as outside scripts see them.

#include "studies/run_command.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <set>

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

/// `maille bench relax --quick --json`, run once for all tests; null where it failed.
const json& quick_relaxation() {
  static const json result = [] {
    const Outcome run = maille_command("bench relax --quick --json");
    return run.code == 0 ? json::parse(run.out) : json();
  }();
  return result;
}

TEST(BenchCommandContract, RelaxReportsEveryCheckThatIsPossibleHere) {
  const json& result = quick_relaxation();
  ASSERT_TRUE(result.is_object());
  EXPECT_GT(result["machine"]["copy_gb_per_s"], 0);
  std::set<std::string> names, omitted;
  for (const json& check : result["checks"]) {
    names.insert(check["name"]);
    EXPECT_TRUE(check["value"].is_number()) << check;
    for (const char* key : {"goal", "met", "predicted"})
      EXPECT_TRUE(check.contains(key)) << check;
  }
  for (const json& note : result["notes"])
    for (const char* name : {"iterations_leg_over_box", "bullet_error_at_equal_time"})
      if (note.get<std::string>().starts_with(name))
        omitted.insert(name);
  for (const char* name :
       {"fem_total_over_coupled_65", "fem_solve_over_coupled_65", "ns_per_node_129_over_33",
        "q1_error_over_coupled_nu49_65", "poke_error_32", "pull_error_16", "limits_active_over_elastic_65",
        "relaxed_over_coupled_129", "bytes_per_node_coupled", "two_threads_speedup",
        "iterations_muscle_over_box", "iterations_leg_over_box", "bullet_error_at_equal_time",
        "xpbd_error_at_equal_time"})
    EXPECT_NE(names.contains(name), omitted.contains(name)) << name;
}

TEST(BenchCommandContract, RelaxHoldsEveryRivalToTheSameAlgebra) {
  const json& result = quick_relaxation();
  ASSERT_TRUE(result.is_object());
  std::set<std::string> methods;
  for (const json& row : result["rows"]) {
    if (!row.contains("algebra_error"))
      continue;
    methods.insert(row["method"]);
    if (row["method"].get<std::string>().starts_with("fem_q1")) {
      EXPECT_LE(row["algebra_error"], 1e-3) << row;
    }
    if (row["method"] == "coupled") {
      EXPECT_LE(row["algebra_error"], row["tolerance"]) << row;
    }
  }
  for (const char* method : {"sweep", "relaxed", "coupled", "fem_q1 cholmod", "fem_q1 umfpack", "fem_q1 amg",
                             "fem_q1 gmg", "fem_q1 gmg-matrix"})
    EXPECT_TRUE(methods.contains(method)) << method;
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
