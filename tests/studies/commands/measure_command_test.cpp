/// `maille bench` and `maille verify` as outside scripts see them.

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

TEST(BenchCommandContract, FiniteElementsReportEverySolver) {
  const Outcome run = maille_command("bench fem --quick --json");
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

TEST(BenchCommandContract, MechanicsReportForcesAndStress) {
  const Outcome run = maille_command("bench mechanics --quick --json");
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

TEST(BenchCommandContract, MaterialsReportEveryTissueAndEveryCheck) {
  const Outcome run = maille_command("bench materials --quick --json");
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

TEST(BenchCommandContract, MaterialsCanBeStopped) {
  const Outcome run = test::shell("timeout --preserve-status -s INT -k 60 8 " + std::string(MAILLE_COMMAND) +
                                  " bench materials --json"); // minutes, otherwise
  ASSERT_EQ(run.code, 1) << run.err;
  const json result = json::parse(run.out);
  EXPECT_TRUE(result["checks"].empty());
  EXPECT_EQ(result["notes"].back(), "interrupted: the rows so far, no checks");
}

/// mpirun, which asks root to say twice that it is meant.
std::string on_ranks(int n) {
  return fmt::format(
      "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 mpirun --oversubscribe -n {} {} ", n,
      MAILLE_COMMAND);
}

// Oracle: one process.
TEST(RanksOracle, CompareGivesTheAnswerOfOneProcess) {
  const std::string arguments =
      fmt::format("compare {}/poke_given_limits.toml --methods limits,fem_q1 --json", MAILLE_SCENES);
  const Outcome together = test::shell(on_ranks(2) + arguments), alone = maille_command(arguments);
  ASSERT_EQ(together.code, 0) << together.err;
  const json ours = json::parse(together.out), truth = json::parse(alone.out);
  ASSERT_EQ(ours["results"].size(), 2u);
  EXPECT_NE(ours["results"][1]["algorithm"].get<std::string>().find("on 2 ranks"), std::string::npos);
  const auto energy = [](const json& result) { return result["results"][1]["strain_energy"].get<double>(); };
  EXPECT_NEAR(energy(ours), energy(truth), 1e-8 * energy(truth));
  const double error = truth["results"][0]["error"]["relative_l2"];
  EXPECT_NEAR(ours["results"][0]["error"]["relative_l2"], error, 1e-8 * error);
  for (const char* where : {"held", "moved"})
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double force = truth["results"][1]["reaction"][where][axis];
      EXPECT_NEAR(ours["results"][1]["reaction"][where][axis], force, 1e-7);
    }
}

// Oracle: one process. Fibres that pull between ends that are held leave nothing but rounding at the free
// nodes.
TEST(RanksOracle, HoldsMayCarryAllThatPulls) {
  const test::TemporaryFolder folder;
  const std::string body =
      "units = \"m, rad\"\n[specimen]\nshape = \"box\"\ncells = [9, 7, 5]\nspacing = [0.0011, 0.0007, "
      "0.0013]\n"
      "material = \"muscle/soleus\"\n[[hold]]\nwhere = \"x-\"\n[[hold]]\nwhere = \"x+\"\n";
  for (const char* load :
       {"contraction = \"3 kPa\"", "where = \"x+\"\ntraction = [\"1 kPa\", \"-2 kPa\", 0]"}) {
    const auto scene = folder.write("held.toml", body + "[[load]]\n" + load + "\n");
    const std::string arguments = fmt::format("compare {} --methods fem_q1,fem_q2 --json", scene.string());
    const Outcome together = test::shell(on_ranks(2) + arguments), alone = maille_command(arguments);
    ASSERT_EQ(together.code, 0) << load << ": " << together.err << together.out;
    const json ours = json::parse(together.out), truth = json::parse(alone.out);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(ours["results"][i]["status"], "done");
      EXPECT_LT(ours["results"][i]["residual"], 1e-6);
      for (std::size_t axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(ours["results"][i]["reaction"]["held"][axis],
                    truth["results"][i]["reaction"]["held"][axis].get<double>(), 1e-9);
    }
  }
}

TEST(RanksContract, TheFirstRankSpeaksForAll) {
  const test::TemporaryFolder folder;
  const auto faulty = folder.write("faulty.toml", "units = \"m, rad\"\n[specimen]\nshape = 3\n");
  const Outcome fault = test::shell(on_ranks(2) + "compare " + faulty.string());
  EXPECT_EQ(fault.code, 2);
  EXPECT_EQ(fault.err.find("specimen.shape"), fault.err.rfind("specimen.shape")) << fault.err;
  const Outcome check = test::shell(on_ranks(2) + fmt::format("check {}/strip_pulled.toml", MAILLE_SCENES));
  EXPECT_EQ(check.code, 0);
  EXPECT_EQ(check.out, maille_command(fmt::format("check {}/strip_pulled.toml", MAILLE_SCENES)).out);
  // An error of the first alone ends the others too.
  const Outcome blocked = test::shell(
      on_ranks(2) + fmt::format("compare {}/strip_pulled.toml --out {}/x", MAILLE_SCENES, faulty.string()));
  EXPECT_NE(blocked.code, 0);
}

TEST(CompareCommandContract, TheBestReferenceAndTheSolverAreChosenByName) {
  const Outcome run =
      maille_command(fmt::format("compare {}/strip_pulled.toml --methods fem_q1 --reference best "
                                 "--reference-seconds 5 --fem-solver amg --json",
                                 MAILLE_SCENES));
  ASSERT_EQ(run.code, 0) << run.err;
  const json result = json::parse(run.out);
  EXPECT_EQ(result["reference"], "best");
  EXPECT_GT(result["reference_error"]["relative_l2"], 0);
  EXPECT_LT(result["results"][0]["error"]["relative_l2"], 0.02);
  EXPECT_NE(result["results"][0]["algorithm"].get<std::string>().find("AMG"), std::string::npos);
  const Outcome wrong =
      maille_command(fmt::format("compare {}/strip_pulled.toml --fem-solver lu", MAILLE_SCENES));
  EXPECT_EQ(wrong.code, 2);
  EXPECT_NE(wrong.err.find("--fem-solver: expected one of automatic, cholmod, amg, gmg, found \"lu\""),
            std::string::npos)
      << wrong.err;
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
  for (const char* method : {"sweep", "relaxed", "coupled", "fem_q1 cholmod", "fem_q1 amg", "fem_q1 gmg"})
    EXPECT_TRUE(methods.contains(method)) << method;
}

TEST(VerifyCommandContract, ReportsEveryProblemAndWritesThePage) {
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
