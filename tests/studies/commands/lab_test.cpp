/// studies/lab/run as outside scripts see it.

#include "studies/commands/run_command.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

namespace maille {
namespace {

using nlohmann::json;
using test::maille_command;
using test::Outcome;

TEST(LabContract, ReportsMachineRowsAndChecks) {
  const Outcome run = maille_command("propagate --quick --json");
  ASSERT_EQ(run.code, 0) << run.err;
  const json result = json::parse(run.out);
  EXPECT_GT(result["machine"]["copy_gb_per_s"], 0);
  EXPECT_EQ(result["rows"].size(), 2u + 1u + 1u + 1u + 4u)
      << "whole bodies, a local drag, many handles, rounding, four hard bodies";
  for (const json& check : result["checks"])
    for (const char* key : {"name", "value", "goal", "met"})
      EXPECT_TRUE(check.contains(key)) << check;
}

TEST(LabContract, FiniteElementsReportEverySolver) {
  const Outcome run = maille_command("fem --quick --json");
  ASSERT_EQ(run.code, 0) << run.err;
  const json result = json::parse(run.out);
  EXPECT_EQ(result["rows"].size(), 2u * 4u + 1u) << "two sizes by four solvers, and quadratic elements";
  for (const json& row : result["rows"]) {
    EXPECT_LT(row["residual"], 1e-9) << row;
    EXPECT_GT(row["peak_mib"], 1) << row;
  }
  EXPECT_EQ(result["checks"][0]["name"], "amg_total_over_default_65");
  EXPECT_EQ(result["checks"][1]["name"], "peak_mib_65");
}

TEST(LabContract, MechanicsReportForcesAndStress) {
  const Outcome run = maille_command("mechanics --quick --json");
  ASSERT_EQ(run.code, 0) << run.err;
  const json result = json::parse(run.out);
  const auto is_of_accuracy = [](const json& row) {
    return row.contains("outputs_of") || row.contains("stress_error_raw");
  };
  EXPECT_EQ(std::ranges::count_if(result["rows"], is_of_accuracy), 1 + 4 * 2)
      << "what outputs cost, and four bodies by two methods";
  std::map<std::string, json> checks;
  for (const json& check : result["checks"])
    checks[check["name"]] = check;
  // Truth: the names and goals that were asked for, and that parts make up the whole.
  for (const auto& [name, goal] : {std::pair{"force_error_worst", 0.05}, std::pair{"stress_error_ratio", 1.0},
                                   std::pair{"recovery_gain", 2.0}, std::pair{"per_label_sum", 1e-10},
                                   std::pair{"outputs_over_solve", 0.3}})
    EXPECT_EQ(checks[name]["goal"], goal) << name;
  EXPECT_EQ(checks["per_label_sum"]["met"], true) << checks["per_label_sum"];
  for (const json& row : result["rows"])
    if (row.contains("stress_error_raw") && row["method"] == "coupled") {
      EXPECT_LT(row["stress_error_recovered"], row["stress_error_raw"]) << row;
    }
}

TEST(LabContract, MaterialsReportEveryTissueAndEveryCheck) {
  const Outcome run = maille_command("materials --quick --json");
  ASSERT_EQ(run.code, 0) << run.err;
  const json result = json::parse(run.out);
  std::map<std::string, std::size_t> rows; // by the key that stands first in a row, and so names its table
  for (const json& row : result["rows"])
    for (const char* key :
         {"bar", "tissue_with_free_ends", "unseen", "fibres_turned", "tissue_pulled", "tissue_and_witness"})
      rows[key] += row.contains(key) ? 1 : 0;
  std::set<std::string> pulled; // each on as many meshes as it needs
  for (const json& row : result["rows"])
    if (row.contains("tissue_pulled"))
      pulled.insert(row["tissue_pulled"].get<std::string>());
  const std::size_t tissues = json::parse(maille_command("materials --json").out).size();
  EXPECT_EQ(rows["bar"], 4u) << "four methods";
  EXPECT_EQ(rows["tissue_with_free_ends"], tissues);
  EXPECT_EQ(pulled.size(), tissues);
  EXPECT_EQ(rows["tissue_and_witness"], tissues);
  EXPECT_EQ(rows["unseen"], 4u * 3u) << "four families of three";
  EXPECT_EQ(rows["fibres_turned"], 2u * 5u) << "two tissues at five angles";
  std::map<std::string, json> checks;
  for (const json& check : result["checks"])
    checks[check["name"]] = check;
  // Truth: the names and goals that were asked for.
  for (const auto& [name, goal] :
       {std::pair{"coupled_error_worst_tissue", 0.02}, std::pair{"fem_offaxis_error_worst", 0.01},
        std::pair{"fit_over_taut_unseen", 0.5}}) {
    ASSERT_TRUE(checks.contains(name)) << name;
    EXPECT_EQ(checks[name]["goal"], goal);
  }
  // Truth: closed forms, which coarse meshes reach as well as fine ones: uniform strain, and a bar.
  EXPECT_LT(checks["fem_offaxis_error_worst"]["value"], 1e-8);
  EXPECT_LT(checks["taut_bar_error"]["value"], 1e-12);
}

TEST(LabContract, MaterialsCanBeStopped) {
  const Outcome run = test::shell("timeout --preserve-status -s INT -k 60 8 " + std::string(MAILLE_COMMAND) +
                                  " materials --json"); // minutes, otherwise
  ASSERT_EQ(run.code, 1) << run.err;
  const json result = json::parse(run.out);
  EXPECT_TRUE(result["checks"].empty());
  EXPECT_EQ(result["notes"].back(), "interrupted: the rows so far, no checks");
}

/// `studies/lab/run relax --quick --json`, run once for all tests; null where it failed.
const json& quick_relaxation() {
  static const json result = [] {
    const Outcome run = maille_command("relax --quick --json");
    return run.code == 0 ? json::parse(run.out) : json();
  }();
  return result;
}

TEST(LabContract, RelaxReportsEveryCheckThatIsPossibleHere) {
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

TEST(LabContract, RelaxHoldsEveryRivalToTheSameAlgebra) {
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
  for (const char* method : {"sweep", "relaxed", "coupled", "fem_q1 cholmod", "fem_q1 amg", "fem_q1 gmg"})
    EXPECT_TRUE(methods.contains(method)) << method;
}

TEST(LabVerifyContract, ReportsEveryProblemAndWritesThePage) {
  const test::TemporaryFolder folder;
  const Outcome run = maille_command("verify --quick --json --markdown " + (folder / "page.md").string());
  ASSERT_EQ(run.code, 0) << run.out << run.err;
  const json result = json::parse(run.out);
  EXPECT_EQ(result["checks"][0]["name"], "verify_missed");
  EXPECT_EQ(result["checks"][0]["value"], 0);
  EXPECT_EQ(result["checks"].back()["name"], "mpi_2_ranks_difference");
  EXPECT_LT(result["checks"].back()["value"], 1e-8);
  for (const json& row : result["rows"])
    for (const char* key :
         {"problem", "method", "quantity", "expected", "computed", "error", "tolerance", "met", "source"})
      EXPECT_TRUE(row.contains(key)) << row;
  std::ifstream page(folder / "page.md");
  const std::string text(std::istreambuf_iterator<char>(page), {});
  EXPECT_NE(text.find("| slender cantilever"), std::string::npos);
}

TEST(LabVerifyContract, AMissedProblemIsExitCodeThree) {
  const test::TemporaryFolder folder; // a CalculiX that fails misses every problem that it is asked
  const auto script = folder.write("ccx", "#!/bin/sh\necho ' *ERROR: out of order'\n");
  std::filesystem::permissions(script, std::filesystem::perms::owner_all);
  const Outcome run =
      test::shell("PATH=" + folder.path().string() + ":$PATH " + MAILLE_COMMAND + " verify --quick --json");
  EXPECT_EQ(run.code, 3) << run.err;
  EXPECT_FALSE(json::parse(run.out)["checks"][0]["met"]);
}

TEST(LabContract, ChoicesAreCheckedOnUnseenScenes) {
#ifdef MAILLE_CHECKS_ACCESS
  GTEST_SKIP() << "the sanitizer takes longer than a scene's reference is given";
#endif
  const Outcome run = maille_command("studies --quick --json");
  ASSERT_EQ(run.code, 0) << run.err;
  const json result = json::parse(run.out);
  std::set<std::string> names;
  for (const json& check : result["checks"])
    names.insert(check["name"]);
  for (const char* name : {"choose_error_kept", "choose_time_kept", "choose_scenes"})
    EXPECT_TRUE(names.contains(name)) << name;
  for (const json& check : result["checks"]) {
    if (check["name"] == "choose_scenes") {
      EXPECT_EQ(check["value"], 6);
    }
  }
}

std::map<std::string, json> checks_of(const json& result) {
  std::map<std::string, json> by_name;
  for (const json& check : result["checks"])
    by_name[check["name"]] = check;
  return by_name;
}

TEST(LabStabilityContract, NoExtremeBreaksAPromise) {
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

TEST(LabStabilityContract, CyclesOfTheRelaxersDoNotDrift) {
  const Outcome run = maille_command("stability --quick --only 'cyclic loading' --json");
  auto checks = checks_of(json::parse(run.out));
  // Truth: an answer depends on its scene alone, so the first and the last cycle are the same to the bit.
  EXPECT_EQ(checks["cyclic_drift_relaxed"]["value"], 0);
  EXPECT_EQ(checks["cyclic_drift_coupled"]["value"], 0);
}

TEST(LabStabilityContract, OneExtremeCanBeAskedAndMakesAPage) {
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
