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

/// The report of `studies/lab/run SUBJECT --quick --json`; each subject runs once.
const json& report(const std::string& subject) {
  static std::map<std::string, json> reports;
  if (!reports.contains(subject)) {
    const Outcome run = maille_command(subject + " --quick --json");
    EXPECT_EQ(run.code, 0) << subject << ": " << run.err;
    reports[subject] = json::parse(run.out);
  }
  return reports[subject];
}

std::map<std::string, json> checks_of(const json& result) {
  std::map<std::string, json> by_name;
  for (const json& check : result["checks"])
    by_name[check["name"]] = check;
  return by_name;
}

/// @param names of checks that a report has, unless a note says why it is omitted
void expect_checks(const std::string& subject, std::initializer_list<const char*> names) {
  const json& result = report(subject);
  EXPECT_GT(result["machine"]["copy_gb_per_s"], 0);
  const auto checks = checks_of(result);
  for (const auto& [name, check] : checks)
    EXPECT_TRUE(check["value"].is_number() && check.contains("goal") && check.contains("met")) << check;
  for (const std::string name : names)
    EXPECT_NE(checks.contains(name), std::ranges::any_of(result["notes"],
                                                         [&](const json& note) {
                                                           return note.get<std::string>().starts_with(name);
                                                         }))
        << name;
}

// Whole bodies, a local drag, many handles, rounding, four hard bodies.
TEST(LabContract, ReportsMachineRowsAndChecks) {
  expect_checks("propagate", {});
  EXPECT_EQ(report("propagate")["rows"].size(), 2u + 1u + 1u + 1u + 4u);
}

TEST(LabContract, FiniteElementsReportEverySolver) {
  expect_checks("fem", {"amg_total_over_default_65", "peak_mib_65"});
  EXPECT_EQ(report("fem")["rows"].size(), 2u * 4u + 1u)
      << "two sizes by four solvers, and quadratic elements";
  for (const json& row : report("fem")["rows"]) {
    EXPECT_LT(row["residual"], 1e-9) << row;
    EXPECT_GT(row["peak_mib"], 1) << row;
  }
}

TEST(LabContract, MechanicsReportForcesAndStress) {
  expect_checks("mechanics", {"force_error_worst", "stress_error_ratio", "recovery_gain", "per_label_sum",
                              "outputs_over_solve"});
  EXPECT_EQ(checks_of(report("mechanics"))["per_label_sum"]["met"], true) << "parts make up the whole";
  for (const json& row : report("mechanics")["rows"])
    if (row.contains("stress_error_raw") && row["method"] == "coupled") {
      EXPECT_LT(row["stress_error_recovered"], row["stress_error_raw"]) << row;
    }
}

TEST(LabContract, MaterialsReportEveryTissueAndEveryCheck) {
  expect_checks("materials", {"coupled_error_worst_tissue", "fit_over_taut_unseen"});
  std::map<std::string, std::size_t> rows; // by the key that stands first in a row, and so names its table
  for (const json& row : report("materials")["rows"])
    ++rows[row.begin().key()];
  const std::size_t tissues = json::parse(maille_command("materials --json").out).size();
  EXPECT_EQ(rows["bar"], 4u) << "four methods";
  EXPECT_EQ(rows["tissue_with_free_ends"], tissues);
  EXPECT_GE(rows["tissue_pulled"], tissues) << "each on as many meshes as it needs";
  EXPECT_EQ(rows["tissue_and_witness"], tissues);
  EXPECT_EQ(rows["unseen"], 4u * 3u) << "four families of three";
  EXPECT_EQ(rows["fibres_turned"], 2u * 5u) << "two tissues at five angles";
  auto checks = checks_of(report("materials"));
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

TEST(LabContract, RelaxReportsEveryCheckThatIsPossibleHere) {
  expect_checks("relax",
                {"fem_total_over_coupled_65", "fem_solve_over_coupled_65", "ns_per_node_129_over_33",
                 "q1_error_over_coupled_nu49_65", "poke_error_32", "pull_error_16",
                 "limits_active_over_elastic_65", "relaxed_over_coupled_129", "bytes_per_node_coupled",
                 "two_threads_speedup", "iterations_muscle_over_box", "iterations_leg_over_box",
                 "bullet_error_at_equal_time", "xpbd_error_at_equal_time"});
}

TEST(LabContract, RelaxHoldsEveryRivalToTheSameAlgebra) {
  std::set<std::string> methods;
  for (const json& row : report("relax")["rows"]) {
    if (!row.contains("algebra_error"))
      continue;
    const std::string method = row["method"];
    methods.insert(method);
    if (method.starts_with("fem_q1")) {
      EXPECT_LE(row["algebra_error"], 1e-3) << row;
    } else if (method == "coupled") {
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
  auto checks = checks_of(json::parse(run.out));
  EXPECT_EQ(checks["verify_missed"]["value"], 0);
  EXPECT_LT(checks["mpi_2_ranks_difference"]["value"], 1e-8);
  EXPECT_NE(test::text_of(folder / "page.md").find("| slender cantilever"), std::string::npos);
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
  expect_checks("studies", {"choose_error_kept", "choose_time_kept", "choose_scenes"});
  EXPECT_EQ(checks_of(report("studies"))["choose_scenes"]["value"], 6);
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
  const std::string text = test::text_of(page);
  EXPECT_NE(text.find("## a single cell"), std::string::npos);
  EXPECT_NE(text.find("| 3D, pulled | `fem_q2` | settled |"), std::string::npos);
  const Outcome wrong = maille_command("stability --only nothing");
  EXPECT_EQ(wrong.code, 2);
  EXPECT_NE(wrong.err.find("a single cell"), std::string::npos) << "names what there is";
}

} // namespace
} // namespace maille
