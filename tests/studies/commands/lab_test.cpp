/// studies/lab/run as outside scripts see it.

#include "studies/commands/run_command.hpp"
#include "support/kit.hpp"

#include <nlohmann/json.hpp>

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
  EXPECT_TRUE(result["machine"]["processor"].is_string());
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
  EXPECT_EQ(report("fem")["rows"].size(), 2u * 4u) << "two sizes by four solvers";
  for (const json& row : report("fem")["rows"])
    EXPECT_TRUE(row["status"] == "done" && row["peak_mib"] > 1) << row;
}

TEST(LabContract, MechanicsReportForcesAndStress) {
  expect_checks("mechanics", {"force_error_worst", "stress_error_ratio"});
  for (const json& row : report("mechanics")["rows"])
    if (row["method"] == "coupled") {
      EXPECT_LT(row["recovered_stress_error"], row["stress_error"]) << row;
    }
}

// Truth: the table: 12 pulls in 3D and 2 in 2D, and a fit, and 2 tissues at 5
// angles, each by its methods and reference.
TEST(LabContract, MaterialsReportEveryPull) {
  expect_checks("materials", {"coupled_error_worst_tissue", "fit_over_taut_unseen"});
  EXPECT_EQ(report("materials")["rows"].size(), 12u * 2u + 2u * 3u + 1u + 2u * 5u * 4u);
}

// Truth: closed forms of five laws, dolfinx, Euler's load, and the promises of twelve random scenes.
TEST(LabContract, FiniteStrainMeetsItsTruths) {
  expect_checks("finite", {"closed_error_worst", "fem_over_dolfinx", "euler_error", "random_broken"});
  const auto checks = checks_of(report("finite"));
  for (const char* const name : {"closed_error_worst", "fem_over_dolfinx", "euler_error"})
    EXPECT_TRUE(!checks.contains(name) || checks.at(name)["met"]) << name;
}

TEST(LabContract, ATableCanBeStopped) {
  const Outcome run = test::shell("timeout --preserve-status -s INT -k 60 8 env " +
                                  std::string(MAILLE_COMMAND) + " materials --json"); // minutes, otherwise
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
                 "default_over_wide_box_65", "bullet_error_at_equal_time"});
}

TEST(LabVerifyContract, ReportsEveryProblemAndWritesThePage) {
  const test::TemporaryFolder folder;
  const Outcome run = maille_command("verify --quick --json --markdown " + (folder / "page.md").string());
  ASSERT_EQ(run.code, 0) << run.out << run.err;
  auto checks = checks_of(json::parse(run.out));
  EXPECT_EQ(checks["verify_missed"]["value"], 0);
  EXPECT_LT(checks["mpi_2_ranks_difference"]["value"], 1e-8);
  EXPECT_TRUE(test::has(test::text_of(folder / "page.md"), "| slender cantilever"));
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
  expect_checks("choices", {"choose_error_kept", "choose_time_kept", "choose_scenes"});
  EXPECT_GE(checks_of(report("choices"))["choose_scenes"]["value"], 1);
}

TEST(LabStabilityContract, NoExtremeBreaksAPromise) {
  const Outcome run = maille_command("stability --quick --json");
  ASSERT_FALSE(run.out.empty()) << run.err;
  const json result = json::parse(run.out);
  std::map<std::string, std::set<std::string>> methods;
  for (const json& row : result["rows"]) {
    EXPECT_EQ(row["broken"], "") << row;
    methods[row["part"]].insert(row["method"]);
  }
  EXPECT_EQ(run.code, 0);
  EXPECT_GE(methods.size(), 10u);
  for (const auto& [part, asked] : methods)
    EXPECT_TRUE(asked.size() == 7 || asked.contains("(reader)") || part == "worlds")
        << part << ": all but quadratic elements";
}

TEST(LabStabilityContract, OnePartCanBeAskedAndMakesAPage) {
  const test::TemporaryFolder folder;
  const std::string page = (folder / "page.md").string();
  const Outcome run = maille_command("stability --quick --only rotation --markdown " + page);
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_TRUE(
      test::has(test::text_of(page), "| both ends of a free body by 90 deg | rotation | fem_q1 | settled |"));
  const Outcome wrong = maille_command("stability --only nothing");
  EXPECT_EQ(wrong.code, 2);
  EXPECT_TRUE(test::has(wrong.err, "rotation")) << "names what there is";
}

} // namespace
} // namespace maille
