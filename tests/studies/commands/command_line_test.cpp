/// The command line: words, help, defaults, and what a wrong word is answered with.

#include "studies/commands/run_command.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace maille {
namespace {

using nlohmann::json;
using test::maille_command;
using test::Outcome;

const char* const box = R"([specimen]
shape = "box"
cells = [3, 2, 2]
spacing = "1 mm"
material = { youngs_modulus = "10 kPa", poisson_ratio = 0.3 }
[[hold]]
where = "x-"
[[move]]
where = "x+"
by = ["0.1 mm", "0 mm", "0 mm"]
)";

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
    const Outcome run = maille_command("run " + folder.scene + " --methods limits,relaxed --steps " +
                                       std::to_string(steps) + " --json");
    ASSERT_EQ(run.code, 0) << run.err;
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
    const Outcome run = maille_command("run " + list + folder.scene + " --json -");
    ASSERT_EQ(run.code, 0) << list << run.err;
    EXPECT_EQ(methods_in(run), (std::vector<std::string>{"limits", "relaxed"})) << list;
  }
}

TEST(CommandLineContract, WrongWordsAreAnsweredWithTheNearestRightOne) {
  const Folder folder;
  const auto message = [&](const std::string& line) {
    const Outcome run = maille_command(line);
    EXPECT_EQ(run.code, 2) << line;
    EXPECT_TRUE(run.out.empty()) << line << run.out;
    return run.err;
  };
  EXPECT_NE(message("comapre " + folder.scene).find("did you mean \"compare\""), std::string::npos);
  EXPECT_NE(message("run " + folder.scene + " --metods limits").find("did you mean \"--methods\""),
            std::string::npos);
  EXPECT_NE(message("run " + folder.scene + " --methods cuopled").find("did you mean \"coupled\""),
            std::string::npos);
  EXPECT_NE(
      message("choose " + folder.scene + " --error 5% --time 1s --of forse").find("did you mean \"force\""),
      std::string::npos);
  const std::string reference = message("compare " + folder.scene + " --reference none");
  EXPECT_EQ(reference.find("--methods"), std::string::npos) << reference;
  EXPECT_NE(reference.find("--reference: expected one of"), std::string::npos) << reference;
  EXPECT_NE(message("help comapre").find("did you mean \"compare\""), std::string::npos);
}

TEST(CommandLineContract, HelpNamesMethodsDefaultsAnExampleAndAPage) {
  for (const std::string line : {"help run", "run --help"}) {
    const Outcome help = maille_command(line);
    EXPECT_EQ(help.code, 0) << line;
    for (const char* part : {"[OPTIONS] SCENE", "relaxed", "fem_q2", "run asks coupled",
                             "Example: maille run", "docs/command.md", "--json [FILE]"})
      EXPECT_NE(help.out.find(part), std::string::npos) << line << ": " << part << "\n" << help.out;
    for (const char* raw : {"[SCENE]", "{false}", "=-", "[FILE]="})
      EXPECT_EQ(help.out.find(raw), std::string::npos) << line << ": " << raw << "\n" << help.out;
  }
  EXPECT_EQ(maille_command("play --help").out.find("{false}"), std::string::npos);
  for (const char* command : {"check", "choose", "compare", "explain", "export", "fit", "materials", "merge",
                              "play", "probe", "report", "run", "study", "trade"}) {
    const Outcome help = maille_command(std::string("help ") + command);
    EXPECT_EQ(help.code, 0) << command;
    EXPECT_NE(help.out.find("Example: maille " + std::string(command)), std::string::npos) << help.out;
    EXPECT_NE(help.out.find("docs/"), std::string::npos) << help.out;
  }
  for (const char* line : {"version", "-v", "--version"})
    EXPECT_TRUE(std::regex_match(maille_command(line).out,
                                 std::regex("maille " MAILLE_VERSION "( \\([0-9a-f]{12}(-dirty)?\\))?\n")))
        << line;
  const std::string columns = maille_command("help columns").out;
  for (const char* word :
       {"total_s", "seconds.total", "set-up and solve", "reference_error.rms", "probe_halvings"})
    EXPECT_NE(columns.find(word), std::string::npos) << word;
  const std::string words = maille_command("help results").out;
  for (const char* word :
       {"done", "clamped", "budget_reached", "interrupted", "refused", "failed", "violation", "residual"})
    EXPECT_NE(words.find(word), std::string::npos) << word;
}

TEST(CommandLineContract, WhatASceneHoldsDoesNotSteerTheTerminal) {
  const Folder folder;
  const std::string scene =
      folder.write("odd.toml", "title = \"a \\u001b]0;b\\u0007\\u009bc\"\n" + std::string(box)).string();
  const Outcome run = maille_command("run " + scene + " --methods limits");
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_NE(run.out.find("a ?]0;b??c\n"), std::string::npos) << run.out;
}

TEST(CommandLineContract, CheckKnowsWhatKindOfFileItIsGiven) {
  const Folder folder;
  const auto code = [&](const std::string& words) { return maille_command("check " + words).code; };
  const std::string study = folder
                                .write("study.toml", "scene = \"box.toml\"\nmethods = [\"limits\"]\n"
                                                     "[[parameter]]\nkey = \"move.0.by.0\"\n"
                                                     "values = [\"0.1 mm\", \"0.2 mm\"]\n")
                                .string();
  EXPECT_EQ(code(study), 0);
  const std::string world =
      folder
          .write("world.toml", "[world]\ncells = [9, 9]\nspacing = \"1 mm\"\n[[object]]\nname = \"a\"\n"
                               "kind = \"rigid\"\nshape = \"box\"\ncells = [2, 2]\n")
          .string();
  const std::string pushed =
      folder.write("pushed.toml", "[[drive]]\nobject = \"a\"\nby = [\"1 mm\", \"0 mm\"]\nframes = 5\n")
          .string();
  EXPECT_EQ(code(world), 0);
  EXPECT_EQ(code(world + " " + pushed), 0);
  EXPECT_EQ(code(pushed + " " + world), 0);
  const Outcome alone = maille_command("check " + pushed);
  EXPECT_EQ(alone.code, 2);
  EXPECT_NE(alone.err.find("the world that it moves"), std::string::npos) << alone.err;
  const std::string wrong =
      folder.write("wrong.toml", "[[drive]]\nobject = \"b\"\nby = [\"1 mm\", \"0 mm\"]\nframes = 5\n")
          .string();
  EXPECT_NE(maille_command("check " + world + " " + wrong).err.find("drive[1].object"), std::string::npos);
  EXPECT_EQ(code(folder.write("soft.toml", "youngs_modulus = \"10 kPa\"\npoisson_ratio = 0.3\n").string()),
            0);
  EXPECT_EQ(code(folder.write("none.toml", "youngs_modulus = \"10 kPa\"\npoisson_ratio = 7\n").string()), 2);
  const Outcome as_json = maille_command("check " + study + " --json");
  EXPECT_EQ(json::parse(as_json.out)["kind"], "study");
}

TEST(CommandLineContract, WordsOfTheLaboratoryNameItsRunner) {
  for (const auto& [line, part] : {std::pair{"bench relax --quick", "studies/lab/run SUBJECT"},
                                   {"verify", "studies/lab/run verify"},
                                   {"stability --json", "studies/lab/run stability"}}) {
    const Outcome run = maille_command(line);
    EXPECT_EQ(run.code, 2) << line;
    EXPECT_NE(run.err.find(part), std::string::npos) << run.err;
    EXPECT_EQ(std::ranges::count(run.err, '\n'), 1) << run.err;
  }
}

} // namespace
} // namespace maille
