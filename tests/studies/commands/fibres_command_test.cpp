/// What the `maille` command says about fibres and what they pull with.

#include "studies/commands/run_command.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdlib>

namespace maille {
namespace {

using nlohmann::json;
using test::maille_command;
using test::Outcome;

const std::string strip = "[specimen]\nshape = \"box\"\ncells = [6, 3, 3]\nspacing = \"1 mm\"\n"
                          "material = { youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }\n"
                          "fibre = { curve = [[0, 0, 0], [\"6 mm\", 0, \"3 mm\"]] }\n"
                          "[[hold]]\nwhere = \"x-\"\n[[load]]\ncontraction = \"1 kPa\"\n";

const json& named(const json& list, const char* key, const char* name) {
  return *std::ranges::find_if(list, [&](const json& entry) { return entry[key] == name; });
}

TEST(FibresCommandContract, ExplainNamesTheContractionAndWhoCarriesIt) {
  const test::TemporaryFolder folder;
  const std::string file = folder.write("strip.toml", strip).string();
  const Outcome run = maille_command("explain " + file + " --json");
  ASSERT_EQ(run.code, 0) << run.err;
  const json result = json::parse(run.out);
  EXPECT_TRUE(named(result["parts"], "name", "contraction")["on"]);
  EXPECT_EQ(named(result["parts"], "name", "fibres cell by cell")["why"], "curve");
  EXPECT_EQ(result["fibres"]["source"], "curve");
  EXPECT_EQ(named(result["memory"]["scene"]["arrays"], "name", "active stress")["bytes"], 8 * 54);
  for (const char* method : {"limits", "relaxed", "sweep"})
    EXPECT_TRUE(named(result["methods"], "method", method)["way"].get<std::string>().starts_with("refuses"))
        << method;
  EXPECT_FALSE(
      named(result["methods"], "method", "coupled")["way"].get<std::string>().starts_with("refuses"));
}

TEST(FibresCommandContract, ComparedSideBySideMethodsRefuseOrAgree) {
  const test::TemporaryFolder folder;
  const std::string file = folder.write("strip.toml", strip).string();
  const Outcome run = maille_command("compare " + file + " --methods limits,relaxed,coupled,fem_q1 --json");
  const json rows = json::parse(run.out)["results"];
  EXPECT_EQ(named(rows, "method", "limits")["status"], "refused");
  EXPECT_EQ(named(rows, "method", "relaxed")["status"], "refused");
  EXPECT_EQ(named(rows, "method", "coupled")["status"], "done");
  EXPECT_EQ(named(rows, "method", "fem_q1")["status"], "done");
}

TEST(FibresCommandData, TheCalfsFibresAreCounted) {
  if (std::getenv("MAILLE_DATA") == nullptr)
    GTEST_SKIP() << "MAILLE_DATA is not set: no calf";
  const std::string file = std::string(MAILLE_SCENES) + "/calf_soleus_dti.toml";
  const Outcome run = maille_command("explain " + file + " --json");
  ASSERT_EQ(run.code, 0) << run.err;
  const json fibres = json::parse(run.out)["fibres"];
  EXPECT_EQ(fibres["cells"], 6417); // the data's README
  const json &lack = fibres["without_direction"], &filled = fibres["filled"];
  EXPECT_EQ(lack["no_tensor"].get<int>() + lack["not_positive"].get<int>() + lack["isotropic"].get<int>(),
            filled["from_neighbours"].get<int>() + filled["from_label"].get<int>() +
                filled["from_body"].get<int>());
  EXPECT_NE(maille_command("check " + file).out.find("fibres: from a tensor image: 6417 cells"),
            std::string::npos);
}

} // namespace
} // namespace maille
