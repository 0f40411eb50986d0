/// `maille fit` as outside scripts see it.

#include "studies/commands/run_command.hpp"
#include "support/kit.hpp"

#include <nlohmann/json.hpp>

namespace maille {
namespace {

using nlohmann::json;
using test::maille_command;
using test::Outcome;

const std::string orthotropic = R"({ E = ["20 kPa", "8 kPa", "8 kPa"], nu = [0.3, 0.3, 0.3], )"
                                R"(G = ["4 kPa", "4 kPa", "3 kPa"] })";

/// A small strip that is moved at its end.
std::string strip(const std::string& by, const std::string& material = orthotropic) {
  return test::box_text("[6, 3, 3]", material) + test::hold_text() + test::move_text(by);
}

class FitCommandContract : public testing::Test {
protected:
  std::string file(const std::string& name, const std::string& text) {
    return folder.write(name + ".toml", text).string();
  }
  const test::TemporaryFolder folder;
  const std::string pulled = file("pulled", strip("[\"0.6 mm\", 0, 0]"));
  const std::string bent = file("bent", strip("[0, 0, \"0.5 mm\"]"));
  const std::string both = file("both", strip("[\"0.4 mm\", 0, \"0.4 mm\"]"));
  const std::string other = file("other", strip("[\"0.1 mm\", \"0.2 mm\", 0]"));
};

std::set<std::string> names(const json& rows) {
  std::set<std::string> list;
  for (const json& row : rows["scenes"])
    list.insert(row["scene"].get<std::string>());
  return list;
}

TEST_F(FitCommandContract, ScenesThatAreHeldOutHaveNoSayInTheFit) {
  const std::string fit = "fit " + pulled + " " + bent + " --reference fem_q1 --json --test ";
  const json first = test::json_of(fit + both), second = test::json_of(fit + other);
  EXPECT_EQ(names(first["fitted"]), (std::set<std::string>{"pulled", "bent"}));
  EXPECT_EQ(first["numbers"], second["numbers"]) << "to the bit";
  EXPECT_EQ(first["fitted"], second["fitted"]);
  EXPECT_EQ(names(first["held_out"]), std::set<std::string>{"both"});
  EXPECT_NE(first["held_out"]["relative_l2"], second["held_out"]["relative_l2"]);
}

TEST_F(FitCommandContract, LotsKeepThePartThatIsAskedForApart) {
  const std::string family = pulled + " " + bent + " " + both + " " + other;
  const json result = test::json_of("fit " + family + " --holdout 0.5 --reference fem_q1 --json");
  std::set<std::string> all = names(result["fitted"]);
  EXPECT_EQ(all.size(), 2u);
  all.merge(names(result["held_out"]));
  EXPECT_EQ(all.size(), 4u) << "none is in both";
  for (const char* key : {"maille", "method", "reference", "status", "trials", "materials", "reasons"})
    EXPECT_TRUE(result.contains(key)) << key;
  for (const char* group : {"fitted", "held_out"})
    for (const json& row : result[group]["scenes"])
      EXPECT_EQ(row["taut"], row["before"]) << "scenes whose material has no limits are taut to begin with";
  for (const json& row : result["fitted"]["scenes"]) {
    EXPECT_GE(row["relative_l2"], row["at_least"]);
    EXPECT_LE(row["alone"].get<double>(), row["relative_l2"].get<double>() * (1 + 1e-12));
  }
}

/// A scene that names the written file has the error that was reported, to rounding.
void expect_same_error(const test::TemporaryFolder& folder, const json& result, const std::string& method) {
  for (const auto& [name, by] : {std::pair{"pulled", "[\"0.6 mm\", 0, 0]"}, {"bent", "[0, 0, \"0.5 mm\"]"}}) {
    const auto scene = folder.write(std::string(name) + "_fitted.toml", strip(by, "\"found.toml\""));
    const json row = test::json_of("compare " + scene.string() + " --methods " + method +
                                   " --reference fem_q1 --json")["results"][0];
    for (const char* group : {"fitted", "held_out"})
      for (const json& expected : result[group]["scenes"])
        if (expected["scene"] == name) {
          EXPECT_EQ(row["status"], expected["status"]);
          EXPECT_NEAR(row["error"]["relative_l2"], expected["relative_l2"].get<double>(), 1e-12) << name;
        }
  }
}

TEST_F(FitCommandContract, TheFileIsAMaterialThatScenesCanName) {
  const std::string file = (folder / "found.toml").string();
  for (const std::string method : {"limits", "relaxed"}) {
    const json found = test::json_of("fit " + pulled + " --test " + bent + " --method " + method +
                                     " --reference fem_q1 --json --out " + file);
    expect_same_error(folder, found, method);
  }
}

/// A belly between tendons that is pulled.
std::string belly(const std::string& by, const std::string& muscle, const std::string& tendon) {
  return "[specimen]\nshape = \"muscle\"\ncells = [12, 4, 4]\nspacing = \"2 mm\"\nmaterial = \"" + muscle +
         "\"\ntendon = { material = \"" + tendon + "\", fraction = 0.2 }\n[[hold]]\nwhere = \"x-\"\n" +
         "[[move]]\nwhere = \"x+\"\nby = " + by + "\n";
}

TEST_F(FitCommandContract, AMuscleAndItsTendonAreFittedTogether) {
  const std::string pull = "[\"0.8 mm\", 0, 0]", more = "[\"1 mm\", 0, 0]", bend = "[0, 0, \"0.6 mm\"]",
                    muscle = "muscle/soleus", tendon = "tendon/tibialis_anterior",
                    out = (folder / "belly.toml").string();
  for (const std::string method : {"limits", "relaxed"}) {
    const Outcome run = maille_command("fit " + file("pull", belly(pull, muscle, tendon)) + " " +
                                       file("bend", belly(bend, muscle, tendon)) + " --test " +
                                       file("more", belly(more, muscle, tendon)) + " --method " + method +
                                       " --trials 400 --reference fem_q1 --json --out " + out);
    ASSERT_EQ(run.code, 1) << "so few trials are the budget: " << run.err;
    const json result = json::parse(run.out);
    ASSERT_EQ(result["materials"].size(), 2u);
    EXPECT_EQ(result["materials"][0]["name"], muscle);
    EXPECT_EQ(result["materials"][1]["name"], tendon);
    EXPECT_EQ(result["numbers"].size(), method == "limits" ? 24u : 6u);
    EXPECT_EQ(names(result["held_out"]), std::set<std::string>{"more"});
    // A scene that names both of them from the file has the error that was reported.
    const auto again =
        folder.write("again.toml", belly(more, "belly.toml#" + muscle, "belly.toml#" + tendon) +
                                       "[limits]\nfrom = \"material\"\n");
    const json row = test::json_of("compare " + again.string() + " --methods " + method +
                                   " --reference fem_q1 --json")["results"][0];
    EXPECT_EQ(row["status"], result["held_out"]["scenes"][0]["status"]);
    EXPECT_NEAR(row["error"]["relative_l2"], result["held_out"]["scenes"][0]["relative_l2"].get<double>(),
                1e-12);
  }
}

TEST_F(FitCommandContract, SaysWhyThereIsNoBetter) {
  const Outcome run = test::done("fit " + pulled + " " + bent + " --holdout 0.5 --reference fem_q1");
  EXPECT_TRUE(test::has(run.out, "not fitted to"));
  EXPECT_TRUE(test::has(run.out, "no Poisson effect"));
  std::string turned = strip("[\"0.6 mm\", 0, 0]");
  turned.insert(turned.find("[[hold]]"), "fibre = { angle = \"30 deg\", plane = \"xy\" }\n");
  const Outcome oblique =
      test::done("fit " + file("turned", turned) + " --test " + pulled + " --reference fem_q1 --json");
  EXPECT_TRUE(test::has(oblique.out, "fibres are turned"));
}

TEST_F(FitCommandContract, AnInterruptEndsWithTheBestSoFar) {
  // limits answer 270,000 nodes: a fit of half a minute, whose first trials are over before the signal
  const auto large = [&](const std::string& name, const std::string& by) {
    std::string text = strip(by);
    text.replace(text.find("[6, 3, 3]"), 9, "[80, 80, 40]");
    return file(name, text);
  };
#ifdef MAILLE_CHECKS_ACCESS
  const std::string seconds = "60 ";
#else
  const std::string seconds = "5 ";
#endif
  const std::string found = (folder / "found.toml").string();
  const Outcome run =
      test::shell("timeout --preserve-status -s INT -k 60 " + seconds + std::string(MAILLE_COMMAND) +
                  " fit " + large("a", "[0, 0, \"1 mm\"]") + " --test " + large("b", "[0, \"1 mm\", 0]") +
                  " --method limits --reference relaxed --json --out " + found);
  ASSERT_EQ(run.code, 128 + 2) << run.err;
  EXPECT_EQ(json::parse(run.out)["status"], "interrupted");
  EXPECT_TRUE(std::filesystem::exists(found));
}

TEST_F(FitCommandContract, WrongUseIsExitCodeTwoAndSaysWhat) {
  std::string loaded = strip("[0, 0, \"0.5 mm\"]") + "[[load]]\ngravity = [0, 0, -9.81]\n";
  const std::string load = file("load", loaded), still = file("still", strip("[0, 0, 0]")),
                    soft = file("soft", strip("[0, 0, \"0.5 mm\"]", "\"muscle/soleus\"")),
                    stiffer = file("stiffer", strip("[0, 0, \"0.5 mm\"]",
                                                    "{ youngs_modulus = \"9 kPa\", poisson_ratio = 0.3 }"));
  test::expect_refused({{"fit", "SCENE"},
                        {"fit " + pulled + " --holdout 0.5", "at least two"},
                        {"fit " + pulled + " " + pulled, "twice"},
                        {"fit " + pulled + " --test " + pulled, "twice"},
                        {"fit " + pulled + " " + bent + " --holdout 0.5 --test " + both, "--holdout"},
                        {"fit " + pulled + " " + bent + " --holdout 1", "--holdout"},
                        {"fit " + pulled + " " + bent + " --method sweep", "sweep"},
                        {"fit " + pulled + " " + bent + " --reference magic", "magic"},
                        {"fit " + pulled + " " + bent + " --out result.txt", "result.txt"},
                        {"fit " + pulled + " " + bent + " --out /none/result.toml", "--out"},
                        {"fit " + pulled + " none.toml", "none.toml"},
                        {"fit " + pulled + " " + load, "load"},
                        {"fit " + pulled + " --test " + soft, "materials that scenes to fit to have"},
                        {"fit " + pulled + " --test " + stiffer, "or another name"},
                        {"fit " + still + " --test " + pulled + " --reference fem_q1", "still"},
                        {"fit " + pulled + " " + bent + " --trials 0", "--trials"}});
}

/// `maille study trade` and `maille study choose` as outside scripts see them.

class TradeCommandContract : public testing::Test {
protected:
  test::TemporaryFolder folder;
  std::string scene = folder
                          .write("bent.toml", "title = \"a bar that is bent\"\n" +
                                                  test::pulled_box_text("[8, 4, 4]", "[0, 0, \"0.5 mm\"]"))
                          .string();
  std::string small = "study trade " + scene +
                      " --methods limits,coupled,fem_q1 --spacings 4,2,1 --tolerances 0.01 "
                      "--reference-seconds 3 --repetitions 1 ";
};

TEST_F(TradeCommandContract, WritesTablesAndPicturesWhole) {
  const Outcome run = test::done(small + "--out " + (folder / "out").string());
  const json result = json::parse(test::text_of(folder / "out/bent_trade.json"));
  EXPECT_EQ(result["rows"].size(), 9u);
  for (const json& row : result["rows"]) {
    EXPECT_EQ(row["status"], "done");
    for (const char* key : {"method", "spacing_factor", "tolerance", "seconds", "bytes", "error", "on_front"})
      EXPECT_TRUE(row.contains(key)) << key;
  }
  EXPECT_EQ(result["whole"], true);
  const std::string csv = test::text_of(folder / "out/bent_trade.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 10);
  EXPECT_EQ(test::text_of(folder / "out/bent_trade.png").substr(1, 3), "PNG");
  const std::string svg = test::text_of(folder / "out/bent_trade.svg");
  EXPECT_TRUE(test::has(svg, "a bar that is bent") && test::has(svg, "</svg>"));
  int n_files = 0;
  for (const auto& file : std::filesystem::directory_iterator(folder / "out"))
    n_files += file.is_regular_file();
  EXPECT_LE(n_files, 4) << "nothing half done is left";
}

TEST_F(TradeCommandContract, ItsTableIsWhatChooseReads) {
  const std::string table = (folder / "t.csv").string();
  test::done(small + "--csv " + table);
  // One scene alone can promise at a level of one half and no more.
  const Outcome half =
      test::done("study choose " + scene + " --error 200% --time 1min --level 50% --json --table " + table);
  EXPECT_FALSE(json::parse(half.out)["chosen"].is_null());
  EXPECT_EQ(maille_command("study choose " + scene + " --error 200% --time 1min --table " + table).code, 1);
}

TEST_F(TradeCommandContract, ChooseSaysWhatMeetsTheWishOrThatNoneDoes) {
  const json result = test::json_of("study choose " + scene + " --error 30% --time 10s --memory 1GiB --json");
  const json& chosen = result["chosen"];
  EXPECT_LE(chosen["error"]["high"], 0.3);
  EXPECT_LE(chosen["seconds"]["high"], 10);
  EXPECT_LE(chosen["error"]["low"], chosen["error"]["expected"]);
  EXPECT_EQ(result["wish"]["bytes"], 1073741824);
  const Outcome none = maille_command("study choose " + scene + " --error 0.0001% --time 16ms");
  EXPECT_EQ(none.code, 1);
  EXPECT_TRUE(test::has(none.out, "none is expected to meet that"));
  EXPECT_TRUE(test::has(none.out, "the most exact in that time"));
  const Outcome small_memory =
      maille_command("study choose " + scene + " --error 30% --time 10s --memory 1kB");
  EXPECT_EQ(small_memory.code, 1);
}

TEST_F(TradeCommandContract, AnInterruptLeavesWhatIsThere) {
  const std::string large =
      folder.write("large.toml", test::pulled_box_text("[96, 96, 96]", "[0, 0, \"1 mm\"]")).string();
  const Outcome run =
      test::shell("timeout --preserve-status -s INT -k 60 4 " + std::string(MAILLE_COMMAND) + " trade " +
                  large + " --methods limits,sweep --reference relaxed --repetitions 100 --json");
  ASSERT_EQ(run.code, 128 + 2) << run.err;
  EXPECT_EQ(json::parse(run.out)["whole"], false);
}

TEST_F(TradeCommandContract, WrongUseIsExitCodeTwoAndSaysWhat) {
  const std::string bad = folder.write("bad.csv", "a,b\n1,2\n").string(),
                    faulty = folder.write("faulty.toml", "[specimen]\nshape = 3\n").string();
  test::expect_refused(
      {{"study trade", "SCENE"},
       {"study trade none.toml", "none.toml"},
       {"study trade " + faulty, "specimen.shape"},
       {"study trade " + scene + " --methods magic", "magic"},
       {"study trade " + scene + " --reference magic", "magic"},
       {"study trade " + scene + " --spacings 3", "--spacings"},
       {"study trade " + scene + " --tolerances 2", "--tolerances"},
       {"study trade " + scene + " --repetitions 0", "--repetitions"},
       {"study trade " + scene + " --csv - --json", "--csv"},
       {"study trade " + scene + " --json /none/x.json", "--json"},
       {"study choose " + scene, "--error"},
       {"study choose " + scene + " --error 5% --time soon", "--time"},
       {"study choose " + scene + " --error much --time 16ms", "--error"},
       {"study choose " + scene + " --error -5% --time 16ms", "--error"},
       {"study choose " + scene + " --error 5% --time 16ms --memory 1stone", "--memory"},
       {"study choose " + scene + " --error 5% --time 16ms --level 100%", "--level"},
       {"study choose " + scene + " --error 5% --time 16ms --table none.csv", "none.csv"},
       {"study choose " + scene + " --error 5% --time 16ms --table " + bad, "bad.csv:1: method"},
       {"study choose " + faulty + " --error 5% --time 16ms --table " + bad,
        "bad.csv:1: method"}, // first of all
       {"study choose none.toml --error 5% --time 16ms", "none.toml"}});
}

} // namespace
} // namespace maille
