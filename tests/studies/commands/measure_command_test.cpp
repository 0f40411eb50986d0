/// `maille compare` over ranks, and references by name.

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

} // namespace
} // namespace maille
