/// The command line: words, help, defaults, and what a wrong word is answered with.

#include "studies/commands/run_command.hpp"
#include "support/kit.hpp"

#include <nlohmann/json.hpp>
#include <regex>

namespace maille {
namespace {

using nlohmann::json;
using test::maille_command;
using test::Outcome;

const std::string box = test::pulled_box_text("[3, 2, 2]", "[\"0.1 mm\", \"0 mm\", \"0 mm\"]");

struct Folder : test::TemporaryFolder {
  std::string scene = write("box.toml", box).string();
};

std::vector<std::string> methods_in(const Outcome& run) {
  std::vector<std::string> names;
  const json result = json::parse(run.out);
  for (const json& row : result.at("results"))
    names.push_back(row.at("method"));
  return names;
}

TEST(CommandLineContract, RunAsksTheElasticMethodAndCompareTheFourThatMatter) {
  const Folder folder;
  EXPECT_EQ(methods_in(maille_command("run " + folder.scene + " --json")),
            (std::vector<std::string>{"coupled"}));
  EXPECT_EQ(methods_in(maille_command("compare " + folder.scene + " --json")),
            (std::vector<std::string>{"limits", "relaxed", "coupled", "fem_q1"}));
}

TEST(CommandLineContract, JsonOfRunIsOneObjectWithARowAMethodAndStep) {
  const Folder folder;
  for (const int steps : {1, 2}) {
    const Outcome run = test::done("run " + folder.scene + " --methods limits,relaxed --steps " +
                                   std::to_string(steps) + " --json");
    const json result = json::parse(run.out);
    EXPECT_EQ(result.at("scene"), "box");
    EXPECT_EQ(result.at("steps"), steps);
    ASSERT_EQ(result.at("results").size(), 2U * static_cast<unsigned>(steps));
    EXPECT_EQ(result["results"].back()["step"], steps);
    EXPECT_EQ(result["results"].back()["method"], "relaxed");
  }
}

TEST(CommandLineContract, AListIsOneWordAndBlanksBehindCommasAreFine) {
  const Folder folder;
  for (const std::string list :
       {"--methods limits,relaxed ", "--method limits,relaxed ", "--methods 'limits, relaxed' ",
        "--methods limits, relaxed ", "--methods=limits,relaxed "}) {
    const Outcome run = test::done("run " + list + folder.scene + " --json -");
    EXPECT_EQ(methods_in(run), (std::vector<std::string>{"limits", "relaxed"})) << list;
  }
}

TEST(CommandLineContract, WrongWordsAreAnsweredWithTheNearestRightOne) {
  const Folder folder;
  test::expect_refused({{"comapre " + folder.scene, "\"compare\""},
                        {"run " + folder.scene + " --metods limits", "\"--methods\""},
                        {"run " + folder.scene + " --methods cuopled", "\"coupled\""},
                        {"study choose " + folder.scene + " --error 5% --time 1s --of forse", "\"force\""},
                        {"compare " + folder.scene + " --reference none", "--reference: expected one of"},
                        {"help comapre", "\"compare\""}});
  EXPECT_FALSE(test::has(maille_command("compare " + folder.scene + " --reference none").err, "--methods"));
}

TEST(CommandLineContract, HelpNamesMethodsDefaultsAnExampleAndAPage) {
  for (const std::string line : {"help run", "run --help"}) {
    const Outcome help = test::done(line);
    for (const char* part : {"[OPTIONS] SCENE", "relaxed", "fem_q2", "run asks coupled",
                             "Example: maille run", "docs/command.md", "--json [FILE]"})
      EXPECT_TRUE(test::has(help.out, part)) << line << ": " << part;
    for (const char* raw : {"[SCENE]", "{false}", "=-", "[FILE]="})
      EXPECT_FALSE(test::has(help.out, raw)) << line << ": " << raw;
  }
  EXPECT_FALSE(test::has(maille_command("play --help").out, "{false}"));
  for (const char* command : {"check", "compare", "fit", "live", "new", "play", "render", "report", "run",
                              "study", "study choose", "study merge", "study trade"}) {
    const Outcome help = test::done(std::string("help ") + command);
    EXPECT_TRUE(test::has(help.out, "Example: maille " + std::string(command)));
    EXPECT_TRUE(test::has(help.out, "docs/"));
  }
  for (const char* line : {"version", "-v", "--version"})
    EXPECT_TRUE(std::regex_match(maille_command(line).out,
                                 std::regex("maille " MAILLE_VERSION "( \\([0-9a-f]{12}(-dirty)?\\))?\n")))
        << line;
  const std::string columns = maille_command("help columns").out;
  for (const char* word :
       {"total_s", "seconds.total", "set-up and solve", "reference_error.rms", "probe_halvings"})
    EXPECT_TRUE(test::has(columns, word)) << word;
  const std::string words = maille_command("help results").out;
  for (const char* word :
       {"done", "clamped", "budget_reached", "interrupted", "refused", "failed", "violation", "residual"})
    EXPECT_TRUE(test::has(words, word)) << word;
}

TEST(CommandLineContract, WhatASceneHoldsDoesNotSteerTheTerminal) {
  const Folder folder;
  const std::string scene =
      folder.write("odd.toml", "title = \"a \\u001b]0;b\\u0007\\u009bc\"\n" + std::string(box)).string();
  const Outcome run = test::done("run " + scene + " --methods limits");
  EXPECT_TRUE(test::has(run.out, "a ?]0;b??c\n"));
}

TEST(CommandLineContract, CheckKnowsWhatKindOfFileItIsGiven) {
  const Folder folder;
  const auto code = [&](const std::string& words) { return maille_command("check " + words).code; };
  const auto file = [&](const char* name, const std::string& text) {
    return folder.write(name, text).string();
  };
  const auto drive = [](const std::string& object) {
    return "[[drive]]\nobject = \"" + object + "\"\nby = [\"1 mm\", \"0 mm\"]\nframes = 5\n";
  };
  const std::string study = file("study.toml", "scene = \"box.toml\"\nmethods = [\"limits\"]\n[[parameter]]\n"
                                               "key = \"move.0.by.0\"\nvalues = [\"0.1 mm\", \"0.2 mm\"]\n"),
                    world = file("world.toml",
                                 test::world_text("[9, 9]") + test::object_text("a", "rigid", "[2, 2]")),
                    pushed = file("pushed.toml", drive("a")), wrong = file("wrong.toml", drive("b"));
  for (const std::string& right : {study, world, world + " " + pushed, pushed + " " + world,
                                   file("soft.toml", "youngs_modulus = \"10 kPa\"\npoisson_ratio = 0.3\n")})
    EXPECT_EQ(code(right), 0) << right;
  test::expect_refused(
      {{"check " + pushed, "the world that it moves"}, {"check " + world + " " + wrong, "drive[1].object"}});
  EXPECT_EQ(code(file("none.toml", "youngs_modulus = \"10 kPa\"\npoisson_ratio = 7\n")), 2);
  EXPECT_EQ(test::json_of("check " + study + " --json")["kind"], "study");
}

TEST(CommandLineContract, WordsOfTheLaboratoryNameItsRunner) {
  for (const auto& [line, part] : {std::pair{"bench relax --quick", "studies/lab/run SUBJECT"},
                                   {"verify", "studies/lab/run verify"},
                                   {"stability --json", "studies/lab/run stability"}}) {
    const Outcome run = test::refused(line);
    EXPECT_TRUE(test::has(run.err, part));
    EXPECT_EQ(std::ranges::count(run.err, '\n'), 1) << run.err;
  }
}

// Truth: the new words print the same.
TEST(OldCommandsConsistent, DoWhatTheyDidAndNameTheNewWords) {
  const std::string strip = std::string(MAILLE_SCENES) + "/strip_pulled.toml";
  for (const auto& [old, now] : {std::pair("explain " + strip, "check --why " + strip),
                                 {"materials muscle/soleus", "check muscle/soleus"},
                                 {"materials", "check library"},
                                 {"export " + strip, "run " + strip + " --write -"},
                                 {"trade --help", "study trade --help"},
                                 {"choose --help", "study choose --help"},
                                 {"merge --help", "study merge --help"},
                                 {"identify --help", "fit --help"},
                                 {"probe --help", "play --help"}}) {
    const Outcome of_old = test::done(old), of_now = test::done(now);
    EXPECT_EQ(of_old.out, of_now.out) << old;
    EXPECT_TRUE(test::has(of_old.err, "is now maille " + now.substr(0, now.find(' ')))) << of_old.err;
    EXPECT_TRUE(of_now.err.empty()) << of_now.err;
  }
  EXPECT_LE(std::ranges::count(test::done("help").out, '\n'), 40) << "one screen";
}

/// `maille check` of tissues as outside scripts see it.

TEST(MaterialsCommandContract, ShowsATissueWithItsSourceAndDerivedConstants) {
  const json tissue = test::json_of("check muscle/vastus_lateralis --json");
  EXPECT_EQ(tissue["name"], "muscle/vastus_lateralis");
  EXPECT_NEAR(tissue["youngs_modulus_pa"][0].get<double>(), 41.8e3, 1); // Knight et al. 2022
  EXPECT_FALSE(tissue["source"].get<std::string>().empty());
  EXPECT_GT(tissue["stiffness_eigenvalues_pa"][0], 0);
  EXPECT_TRUE(test::has(maille_command("check library").out, "muscle/soleus"));
  ASSERT_EQ(tissue["nearly_incompressible"].size(), 2u);
  EXPECT_NEAR(tissue["nearly_incompressible"][1]["bulk_modulus_pa"].get<double>(), 577e3, 1e-6);
}

TEST(MaterialsCommandContract, SaysWhatIsNotVerified) {
  const auto says = [](const std::string& arguments, const char* words) {
    return maille_command("check " + arguments).out.find(words) != std::string::npos;
  };
  EXPECT_TRUE(says("liver/parenchyma", "damage       stretch 1.462: "));
  EXPECT_TRUE(says("tendon/tibialis_anterior", "damage       stretch 1.08 (UNVERIFIED): "));
  // 1 / 1.462^2 and 1.462 - 1 / 1.462
  EXPECT_TRUE(
      says("liver/parenchyma", "compress 0.4678 (follows from the stretch), shear 12 0.778 (follows"));
  EXPECT_TRUE(says("skin/dermis", "NO: do not quote these numbers as fact"));
  const json all = json::parse(maille_command("check library --json").out);
  const std::string table = maille_command("check library").out;
  for (const json& tissue : all) { // in every table, not only in its own
    const auto line = table.find("\n" + tissue["name"].get<std::string>() + " ");
    ASSERT_NE(line, std::string::npos) << tissue["name"];
    const bool is_marked =
        table.substr(line + 1, table.find('\n', line + 1) - line).find("UNVERIFIED") != std::string::npos;
    EXPECT_EQ(is_marked, !tissue["verified"].get<bool>()) << tissue["name"];
  }
}

/// The `maille` command where limits, sizes and files of a scene are in question.

/// A bar of 8 mm pulled by `by`, with limits of its own of 10 %.
std::string bar(const std::string& by, const std::string& more) {
  return test::box_text("[8, 2, 2]", "{ youngs_modulus = \"10 kPa\", poisson_ratio = 0.3, stretch = 1.1, "
                                     "compress = 0.9, shear = 0.1 }") +
         test::hold_text() + test::move_text("[\"" + by + "\", 0, 0]") + more;
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
          maille_command(fmt::format("{} {} --methods {} --json", command, file.string(), one.method));
      EXPECT_EQ(run.code, one.code) << command << " " << one.method << " " << one.limits << run.err;
      const json out = json::parse(run.out);
      EXPECT_EQ((out.is_array() ? out.at(0) : out).at("results").at(0).at("status"), one.status);
    }
  }
}

TEST(CheckCommandContract, ShowsSizesAndLabelsAndWarns) {
  const test::TemporaryFolder folder;
  const auto file = folder.write("bar.toml", bar("4 mm", ""));
  const Outcome check = test::done("check " + file.string());
  for (const char* words : {"size 8 x 2 x 2 mm", "50 % of the length",
                            "warning: the moves ask for a mean strain of 50 %", "32 mm^3"})
    EXPECT_TRUE(test::has(check.out, words));
  for (const std::string& command :
       {"check --why " + file.string(), "run " + file.string() + " --methods coupled"})
    EXPECT_TRUE(test::has(maille_command(command).out, "warning: the moves")) << command;
  const json out = test::json_of("check --json - " + file.string());
  EXPECT_EQ(out.at("warnings").size(), 1u);
  EXPECT_EQ(out.at("parts").at(0).at("voxels"), 32);
  std::string tiny = test::box_text("[8]") + test::hold_text();
  tiny.replace(tiny.find("1 mm"), 4, "1e-320 m");
  test::refused("check " + folder.write("tiny.toml", tiny).string()); // as every method would
}

TEST(CheckCommandContract, SandboxedScenesReadWhatLiesBesideThem) {
  const test::TemporaryFolder folder;
  folder.write("soft.toml", "youngs_modulus = \"10 kPa\"\npoisson_ratio = 0.3\n");
  const auto file = folder.write(
      "bar.toml", test::box_text("[8]", "\"" + (folder / "soft.toml").string() + "\"") + test::hold_text());
  test::done("check " + file.string());
  test::expect_refused({{"check --sandbox " + file.string(), "--sandbox"}});
}

/// What the `maille` command says about fibres and what they pull with.

const std::string strip = test::box_text("[6, 3, 3]") +
                          "fibre = { curve = [[0, 0, 0], [\"6 mm\", 0, \"3 mm\"]] }\n" + test::hold_text() +
                          "[[load]]\ncontraction = \"1 kPa\"\n";

const json& named(const json& list, const char* key, const char* name) {
  return *std::ranges::find_if(list, [&](const json& entry) { return entry[key] == name; });
}

TEST(FibresCommandContract, ExplainNamesTheContractionAndWhoCarriesIt) {
  const test::TemporaryFolder folder;
  const std::string file = folder.write("strip.toml", strip).string();
  const json result = test::json_of("check --why " + file + " --json");
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
  const json rows =
      test::json_of("compare " + file + " --methods limits,relaxed,coupled,fem_q1 --json")["results"];
  for (const char* method : {"limits", "relaxed", "coupled", "fem_q1"})
    EXPECT_EQ(named(rows, "method", method)["status"],
              method == std::string("limits") || method == std::string("relaxed") ? "refused" : "done");
}

TEST(FibresCommandData, TheCalfsFibresAreCounted) {
  if (std::getenv("MAILLE_DATA") == nullptr)
    GTEST_SKIP() << "MAILLE_DATA is not set: no calf";
  const std::string file = std::string(MAILLE_SCENES) + "/calf_soleus_dti.toml";
  const json fibres = test::json_of("check --why " + file + " --json")["fibres"];
  EXPECT_EQ(fibres["cells"], 6417); // the data's README
  const json &lack = fibres["without_direction"], &filled = fibres["filled"];
  EXPECT_EQ(lack["no_tensor"].get<int>() + lack["not_positive"].get<int>() + lack["isotropic"].get<int>(),
            filled["from_neighbours"].get<int>() + filled["from_label"].get<int>() +
                filled["from_body"].get<int>());
  EXPECT_TRUE(test::has(maille_command("check " + file).out, "fibres: from a tensor image: 6417 cells"));
}

/// `maille compare` over ranks, and references by name.

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
  EXPECT_TRUE(test::has(ours["results"][1]["algorithm"].get<std::string>(), "on 2 ranks"));
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
  const json result =
      test::json_of(fmt::format("compare {}/strip_pulled.toml --methods fem_q1 --reference best "
                                "--reference-seconds 5 --fem-solver amg --json",
                                MAILLE_SCENES));
  EXPECT_EQ(result["reference"], "best");
  EXPECT_GT(result["reference_error"]["relative_l2"], 0);
  EXPECT_LT(result["results"][0]["error"]["relative_l2"], 0.02);
  EXPECT_TRUE(test::has(result["results"][0]["algorithm"].get<std::string>(), "AMG"));
  test::expect_refused({{fmt::format("compare {}/strip_pulled.toml --fem-solver lu", MAILLE_SCENES),
                         "--fem-solver: expected one of automatic, cholmod, amg, gmg, found \"lu\""}});
}

} // namespace
} // namespace maille
