/// The `maille` command where limits, sizes and files of a scene are in question.

#include "studies/commands/run_command.hpp"
#include "support/temporary_folder.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace maille {
namespace {

using nlohmann::json;

using test::Outcome;

Outcome maille(const std::string& arguments) {
  return test::maille_command(arguments);
}

/// A bar of 8 mm pulled by `by`, with limits of its own of 10 %.
std::string bar(const std::string& by, const std::string& more) {
  return "[specimen]\nshape = \"box\"\ncells = [8, 2, 2]\nspacing = \"1 mm\"\nmaterial = { youngs_modulus = "
         "\"10 kPa\", "
         "poisson_ratio = 0.3, stretch = 1.1, compress = 0.9, shear = 0.1 }\n[[hold]]\nwhere = "
         "\"x-\"\n[[move]]\nwhere = \"x+\"\nby "
         "= [\"" +
         by + "\", 0, 0]\n" + more;
}

// Truth: 2 mm of 8 are more than a tenth.
TEST(LimitsCommandContract, MovesThatLimitsCutFailTheRunUnlessTheSceneAllowsIt) {
  const test::TemporaryFolder folder;
  struct Case {
    std::string method, limits;
    int code;
    const char* status;
  };
  for (const Case& one :
       {Case{"coupled", "", 0, "done"}, Case{"relaxed", "", 0, "done"}, Case{"limits", "", 1, "clamped"},
        Case{"coupled", "[limits]\nfrom = \"none\"\n", 0, "done"},
        Case{"coupled", "[limits]\nfrom = \"material\"\n", 1, "clamped"},
        Case{"coupled", "[limits]\nfrom = \"material\"\ncut = \"allowed\"\n", 0, "clamped"},
        Case{"limits", "[limits]\ncut = \"allowed\"\n", 0, "clamped"}}) {
    const auto file = folder.write("bar.toml", bar("2 mm", one.limits));
    for (const char* command : {"run", "compare"}) {
      const Outcome run =
          maille(fmt::format("{} {} --methods {} --json", command, file.string(), one.method));
      EXPECT_EQ(run.code, one.code) << command << " " << one.method << " " << one.limits << run.err;
      const json out = json::parse(run.out);
      EXPECT_EQ((out.is_array() ? out.at(0) : out).at("results").at(0).at("status"), one.status);
    }
  }
}

TEST(CheckCommandContract, ShowsSizesAndLabelsAndWarns) {
  const test::TemporaryFolder folder;
  const auto file = folder.write("bar.toml", bar("4 mm", ""));
  const Outcome check = maille("check " + file.string());
  EXPECT_EQ(check.code, 0);
  for (const char* words : {"size 8 x 2 x 2 mm", "50 % of the length",
                            "warning: the moves ask for a mean strain of 50 %", "32 mm^3"})
    EXPECT_NE(check.out.find(words), std::string::npos) << check.out;
  for (const std::string& command :
       {"explain " + file.string(), "run " + file.string() + " --methods coupled"})
    EXPECT_NE(maille(command).out.find("warning: the moves"), std::string::npos) << command;
  const json out = json::parse(maille("check --json - " + file.string()).out);
  EXPECT_EQ(out.at("warnings").size(), 1u);
  EXPECT_EQ(out.at("parts").at(0).at("voxels"), 32);
  const auto tiny = folder.write(
      "tiny.toml", "[specimen]\nshape = \"box\"\ncells = [8]\nspacing = \"1e-320 m\"\nmaterial = "
                   "\"muscle/soleus\"\n[[hold]]\nwhere = \"x-\"\n");
  EXPECT_EQ(maille("check " + tiny.string()).code, 2) << "every method would refuse it";
}

TEST(CheckCommandContract, SandboxedScenesReadWhatLiesBesideThem) {
  const test::TemporaryFolder folder;
  folder.write("soft.toml", "youngs_modulus = \"10 kPa\"\npoisson_ratio = 0.3\n");
  const auto file =
      folder.write("bar.toml", "[specimen]\nshape = \"box\"\ncells = [8]\nspacing = \"1 mm\"\nmaterial = \"" +
                                   (folder / "soft.toml").string() + "\"\n[[hold]]\nwhere = \"x-\"\n");
  EXPECT_EQ(maille("check " + file.string()).code, 0);
  const Outcome refused = maille("check --sandbox " + file.string());
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("--sandbox"), std::string::npos) << refused.err;
}

} // namespace
} // namespace maille
