/// The `maille` command as outside scripts see it: output formats, exit codes, files.

#include "studies/commands/run_command.hpp"
#include "support/kit.hpp"

#include <nlohmann/json.hpp>

namespace maille {
namespace {

using nlohmann::json;

using test::maille_command;
using test::Outcome;
using test::shell;

const std::string strip = std::string(MAILLE_SCENES) + "/strip_pulled.toml";

TEST(CompareCommandContract, JsonHasTheFieldsOfTheDesign) {
  const json result = test::json_of("compare " + strip + " --methods limits,sweep,fem_q1,fem_q2 --json");
  EXPECT_EQ(result.at("scene"), "strip_pulled");
  EXPECT_EQ(result.at("maille"), MAILLE_VERSION);
  EXPECT_EQ(result.at("dimension"), 3);
  EXPECT_EQ(result.at("cells"), 32 * 8 * 8);
  EXPECT_EQ(result.at("nodes"), 33 * 9 * 9);
  EXPECT_GE(result.at("threads"), 1);
  EXPECT_EQ(result.at("reference"), "fem_q2");
  ASSERT_EQ(result.at("results").size(), 4u);
  for (const json& row : result.at("results")) {
    EXPECT_EQ(row.at("status"), "done") << row;
    for (const char* key : {"setup", "solve", "total"})
      EXPECT_GE(row.at("seconds").at(key), 0) << row;
    EXPECT_GT(row.at("bytes"), 0);
    EXPECT_GE(row.at("iterations"), 0);
    // The scene asks for no limits: methods that know nothing else have some, finite elements none to break.
    const bool is_elastic = row.at("method").get<std::string>().starts_with("fem_");
    EXPECT_EQ(row.at("limit_violation").is_null(), is_elastic) << row;
    EXPECT_TRUE(is_elastic || row.at("limit_violation") >= 0) << row;
    const bool is_reference = row.at("method") == "fem_q2";
    ASSERT_EQ(row.contains("error"), !is_reference) << row;
    if (!is_reference) {
      for (const char* key : {"relative_l2", "relative_max", "rms"})
        EXPECT_GE(row.at("error").at(key), 0) << row;
    }
  }
}

// Truth: the system, which grants no more than its limit.
TEST(ExplainCommandContract, SaysHowManyVoxelsMergedIntoOneFit) {
  const test::TemporaryFolder folder;
  constexpr int n = 96;
  std::string voxels;
  for (const auto& [x, y, z] : test::all_below({n, n, n}))
    voxels += z % 16 < 4 || (x / 8 + y / 8) % 2 == 0 ? '\1' : '\0';
  folder.write("body.raw", voxels);
  folder.write("body.mhd", "ObjectType = Image\nNDims = 3\nDimSize = 96 96 96\nElementSpacing = 1 1 1\n"
                           "ElementType = MET_UCHAR\nElementDataFile = body.raw\n");
  const auto scene = [&](const std::string& coarsen) {
    return folder
        .write("body" + coarsen + ".toml",
               "[specimen]\nshape = \"image\"\nimage = \"body.mhd\"\ncoarsen = " + coarsen +
                   "\nlabels = { 1 = { youngs_modulus = \"10 kPa\", poisson_ratio = 0.3, name = \"gel\" } "
                   "}\n[[hold]]\nwhere = \"z-\"\n[[move]]\nwhere = \"z+\"\nby = [0, 0, \"1 mm\"]\n")
        .string();
  };
  const auto limited = [](const std::string& command) {
    return shell("ulimit -v 300000; " + std::string(MAILLE_COMMAND) + " " + command);
  };
  const Outcome run = limited("check --why " + scene("1") + " --json");
  ASSERT_EQ(run.code, 0) << run.err;
  const json result = json::parse(run.out);
  EXPECT_GT(result.at("run_bytes_at_most"), result.at("available_bytes"));
  EXPECT_EQ(result.at("coarsen_times_that_fits"), 2);
  EXPECT_TRUE(test::has(limited("check --why " + scene("1")).out, "with 2 times the scene's `coarsen`"));
  EXPECT_FALSE(
      json::parse(limited("check --why " + scene("2") + " --json").out).contains("run_bytes_at_most"));
  EXPECT_EQ(limited("run " + scene("2")).code, 0);
}

TEST(CompareCommandContract, JsonMayNameAFileAndNeverTakesTheSceneForIt) {
  const test::TemporaryFolder folder;
  const Outcome to_file = test::done("compare " + strip + " --methods limits --reference fem_q1 --json " +
                                     (folder / "r.json").string());
  EXPECT_TRUE(test::has(to_file.out, "limits")) << "the table stays on stdout";
  std::ifstream file(folder / "r.json");
  EXPECT_EQ(json::parse(file).at("results").size(), 2u);

  const Outcome swallowed = test::done("check --json " + strip);
  EXPECT_EQ(json::parse(swallowed.out).at("faults").size(), 0u);
}

TEST(CompareCommandContract, WritesWhatParaViewOpens) {
  const test::TemporaryFolder folder;
  // Into a folder that is not there yet.
  const std::string out = (folder / "new/out").string();
  test::done("compare " + strip + " --methods limits,fem_q1 --out " + out + " --csv " + out +
             "/table.csv --json " + out + "/table.json");
  for (const char* name :
       {"strip_pulled_limits.vti", "strip_pulled_fem_q1.vti", "strip_pulled.vtm", "strip_pulled_compare.json",
        "strip_pulled_compare.csv", "table.csv", "table.json"})
    EXPECT_TRUE(std::filesystem::exists(folder / "new/out" / name)) << name;
}

TEST(CompareCommandContract, CsvHasAHeaderAndALineAMethod) {
  const Outcome run = test::done("compare " + strip + " --methods limits,fem_q1 --csv -");
  EXPECT_EQ(run.out.substr(0, 20), "scene,method,status,");
  EXPECT_EQ(std::count(run.out.begin(), run.out.end(), '\n'), 3);
}

TEST(RunCommandContract, StepsMakeASeries) {
  const test::TemporaryFolder folder;
  const Outcome run =
      test::done("run " + strip + " --methods limits --steps 3 --out " + folder.path().string());
  const std::string text = test::text_of(folder / "strip_pulled_limits.pvd");
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n') > 3, true);
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
    files += entry.path().extension() == ".vti";
  EXPECT_EQ(files, 4u) << "the body at rest and three steps";
}

// Six objects, coloured by one picture of 144 x 96 pixels of four bytes.
TEST(ExplainCommandAnalytic, CountsThePicturesOfLooks) {
  const Outcome run = test::done("check --why " + std::string(MAILLE_SCENES) + "/render/puzzle.toml --json");
  EXPECT_EQ(json::parse(run.out).at("looks_bytes"), 6 * 144 * 96 * 4);
}

TEST(CommandContract, FaultyInputIsExitCodeTwoWithEveryFault) {
  const test::TemporaryFolder folder;
  const auto file =
      folder.write("bad.toml", "[specimen]\nshape = \"box\"\ncells = [2, 2]\nspacing = \"-1 mm\"\n"
                               "material = \"muscle/none\"\n[[hold]]\nwhere = \"x-\"\n");
  for (const char* command : {"check", "compare", "run", "check --why"}) {
    const Outcome run = test::refused(std::string(command) + " " + file.string());
    EXPECT_TRUE(run.out.empty()) << run.out;
    EXPECT_TRUE(test::has(run.err, "bad.toml:4: specimen.spacing"));
    EXPECT_TRUE(test::has(run.err, "bad.toml:5: specimen.material"));
  }
  const Outcome machine_readable = test::refused("check --json - " + file.string());
  EXPECT_EQ(json::parse(machine_readable.out).at("faults").at(0).at("line"), 4);
}

TEST(CommandContract, WrongUseIsExitCodeTwo) {
  for (const std::string& use :
       {std::string(), std::string("compare"), std::string("compare no_such_scene.toml"), "dance " + strip,
        "run " + strip + " --steps 0", std::string("check muscle/none")})
    test::refused(use);
  test::expect_refused({{"compare " + strip + " --methods limits,magic", "magic"}});
}

TEST(CommandContract, FolderThatCannotBeWrittenIsFoundBeforeTheWork) {
  const test::TemporaryFolder folder;
  folder.write("file", "not a folder");
  const Outcome run = test::refused("compare " + strip + " --out " + (folder / "file/out").string());
  EXPECT_TRUE(run.out.empty()) << run.out;
  EXPECT_TRUE(test::has(run.err, "--out"));
}

TEST(CommandContract, FilesThatCannotBeWrittenAreFoundBeforeTheWork) {
  const test::TemporaryFolder folder;
  const std::string nowhere = (folder / "none/result").string();
  for (const std::string option : {"--json", "--csv"}) {
    const Outcome run = test::refused("compare " + strip + " " + option + " " + nowhere);
    EXPECT_TRUE(run.out.empty()) << run.out;
    EXPECT_TRUE(test::has(run.err, option));
  }
  test::refused("compare " + strip + " --picture " + nowhere + ".png");
  test::refused("compare " + strip + " --picture " + (folder / "a.jpg").string());
  test::refused("compare " + strip + " --json --csv -"); // two results on one stdout
}

/// The specimen of a scene; conditions follow.
const std::string small_box = test::box_text("[4, 2, 2]");

/// A block whose sweeps take minutes.
const std::string slow_scene = test::pulled_box_text("[60, 60, 60]", "[\"2 mm\", 0, 0]") + R"([relaxation]
tolerance = 1e-12
[limits]
from = "given"
stretch = 2
compress = 0.1
shear = 1
)";

TEST(CommandContract, InterruptEndsARunWithItsStatusAndNoStepOfTheSeries) {
  const test::TemporaryFolder folder;
  const auto file = folder.write("slow.toml", slow_scene);
  // timeout sends SIGINT after five seconds (loading libraries takes one or two under load) and, should that
  // not help, ends the test by force after thirty.
  const Outcome run =
      shell("timeout --preserve-status -s INT -k 30 5 " + std::string(MAILLE_COMMAND) + " run " +
            file.string() + " --methods sweep --json --out " + folder.path().string());
  EXPECT_EQ(run.code, 128 + 2) << run.err;
  EXPECT_EQ(json::parse(run.out)["results"][0]["status"], "interrupted");
  EXPECT_FALSE(std::filesystem::exists(folder / "slow_sweep_0001.vti")) << "a partial state is no step";
}

TEST(CommandContract, ARunThatAnswersNothingIsAFailure) {
  const test::TemporaryFolder folder;
  const auto file =
      folder.write("load.toml", small_box + test::hold_text() + "[[load]]\ngravity = [0, 0, -9.81]\n");
  test::done("run " + file.string() + " --methods limits", 1);
  test::done("run " + file.string() + " --methods fem_q1");
}

TEST(CommandContract, LoadsAreRefusedByTheLimitMethodsAndCarriedByFem) {
  const test::TemporaryFolder folder;
  const auto file =
      folder.write("load.toml", small_box + test::hold_text() +
                                    "[[load]]\nwhere = \"x+\"\ntraction = [\"100 Pa\", 0, 0]\n");
  const json result = test::json_of("compare " + file.string() + " --methods limits,fem_q1 --json");
  EXPECT_EQ(result["results"][0]["status"], "refused");
  EXPECT_FALSE(result["results"][0]["message"].get<std::string>().empty());
  EXPECT_FALSE(result["results"][0].contains("error"));
  EXPECT_EQ(result["results"][1]["status"], "done");
}

TEST(CommandContract, ABodyThatCanStillMoveRigidlyIsAFailedComparison) {
  const test::TemporaryFolder folder;
  const auto file = folder.write("loose.toml", small_box + test::hold_text() + "axes = \"x\"\n");
  // No reference, so no comparison.
  const Outcome run = test::done("compare " + file.string() + " --methods limits,fem_q1 --json", 1);
  EXPECT_EQ(json::parse(run.out)["results"][1]["status"], "refused");
}

TEST(ExplainCommandContract, CountsWhatTheSceneHas) {
  const json result = test::json_of("check --why " + strip + " --json");
  EXPECT_EQ(result["nodes"], 33 * 9 * 9);
  EXPECT_EQ(result["links"], 32 * 9 * 9 + 2 * 33 * 8 * 9);
  const auto bytes = [&](const char* holder, const std::string& name) {
    for (const json& array : result["memory"][holder]["arrays"])
      if (array["name"] == name)
        return array["bytes"].get<int>();
    return -1;
  };
  EXPECT_EQ(bytes("limits", "answer"), 33 * 9 * 9 * 3 * 8);
  EXPECT_EQ(bytes("scene", "material numbers"), 0) << "a homogeneous box pays for none";
  EXPECT_EQ(bytes("scene", "fibres"), 0);
  EXPECT_EQ(bytes("drag", "displacement x"), 48 * 9 * 9 * 4); // rows of 33 are padded to 48
  EXPECT_EQ(bytes("drag", "held x"), (33 * 9 * 9 + 63) / 64 * 8);
  EXPECT_EQ(bytes("drag", "matter"), -1) << "the body fills its grid";
  for (const json& holder : result["memory"]) {
    int sum = 0;
    for (const json& array : holder["arrays"])
      sum += array["bytes"].get<int>();
    EXPECT_EQ(holder["bytes"], sum);
  }
  EXPECT_EQ(result["limits_route"],
            (std::vector<std::string>{"separable scans", "nothing moves", "nothing moves"}));
  EXPECT_EQ(result["methods"][0]["way"], "separable scans");
  EXPECT_EQ(result["methods"][0]["bytes_at_most"], result["memory"]["limits"]["bytes"]);
}

} // namespace
} // namespace maille
