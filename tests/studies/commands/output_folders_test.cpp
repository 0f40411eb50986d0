/// What commands write, and what they must not touch.

#include "studies/commands/run_command.hpp"
#include "support/kit.hpp"

#include <nlohmann/json.hpp>

#include <fcntl.h>
#include <unistd.h>

namespace maille {
namespace {

namespace fs = std::filesystem;
using test::maille_command;
using test::Outcome;

std::string box_of(const std::string& move) {
  return test::pulled_box_text("[3, 2, 2]", "[\"" + move + "\", \"0 mm\", \"0 mm\"]");
}

struct Folder : test::TemporaryFolder {
  std::string scene = write("box.toml", box_of("0.1 mm")).string();
  std::string other = write("bar.toml", box_of("0.2 mm")).string();
  std::string out = (path() / "out").string();
  Folder() {
    fs::create_directories(out);
    fs::create_directories(path() / "tables");
  }

  std::set<std::string> names() const {
    std::set<std::string> found;
    for (const auto& entry : fs::directory_iterator(out))
      found.insert(entry.path().filename().string());
    return found;
  }
  std::string text(const fs::path& file) const { return test::text_of(path() / file); }
  std::string study() const {
    return write("study.toml",
                 "scene = \"box.toml\"\nmethods = [\"limits\"]\nreference = \"none\"\n[[parameter]]\n"
                 "key = \"move.0.by.0\"\nvalues = [\"0.1 mm\"]\n")
        .string();
  }
};

TEST(OutputFolderContract, ResultsOfTheSameSceneAreReplacedAsASet) {
  const Folder folder;
  test::done("run " + folder.scene + " --methods coupled --steps 4 --out " + folder.out);
  ASSERT_EQ(folder.names().size(), 5U + 1 + 1 + 1)
      << "rest, four steps, their list, their forces, the results";
  test::done("run " + folder.scene + " --methods limits --out " + folder.out);
  EXPECT_EQ(folder.names(), (std::set<std::string>{"box_limits_0001.vti", "box_run_results.json"}));
  // Two kinds of results of one text lie side by side; of another text they would not belong together.
  test::done("compare " + folder.scene + " --methods limits,fem_q1 --out " + folder.out);
  EXPECT_TRUE(folder.names().contains("box_limits_0001.vti"));
  folder.write("box.toml", box_of("0.3 mm"));
  test::done("compare " + folder.scene + " --methods limits,fem_q1 --out " + folder.out);
  EXPECT_EQ(folder.names(),
            (std::set<std::string>{"box.vtm", "box_compare.csv", "box_compare.json",
                                   "box_compare_results.json", "box_fem_q1.vti", "box_limits.vti"}));
}

TEST(OutputFolderContract, ResultsOfOthersNeedOverwrite) {
  const Folder folder;
  test::done("run " + folder.scene + " --methods limits --out " + folder.out);
  folder.write("out/notes.txt", "mine");
  const std::set<std::string> before = folder.names();
  const Outcome refused = test::refused("compare " + folder.other + " --methods limits --out " + folder.out);
  EXPECT_TRUE(test::has(refused.err, "--overwrite"));
  EXPECT_EQ(folder.names(), before);
  test::done("run " + folder.other + " --methods limits --overwrite --out " + folder.out);
  EXPECT_EQ(folder.names(),
            (std::set<std::string>{"bar_limits_0001.vti", "bar_run_results.json", "notes.txt"}));

  auto results = nlohmann::ordered_json::parse(folder.text("out/bar_run_results.json"));
  results["maille"] = "0.0.1";
  folder.write("out/bar_run_results.json", results.dump());
  test::refused("run " + folder.other + " --methods limits --out " + folder.out);
}

/// Every file, link and folder below, with its content.
std::map<std::string, std::string> tree_of(const fs::path& root) {
  std::map<std::string, std::string> tree;
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    std::ifstream stream(entry.path(), std::ios::binary);
    tree[entry.path().string()] = entry.is_symlink() ? "link to " + fs::read_symlink(entry).string()
                                  : entry.is_directory()
                                      ? "folder"
                                      : std::string(std::istreambuf_iterator<char>(stream), {});
  }
  return tree;
}

/// A name that a foreign list of results may hold.
std::string hostile_name(std::mt19937& dice, const std::string& root) {
  static const std::vector<std::string> stems{
      "thesis",     "box_thesis", "box_limits",      "bar_coupled", "docs",          "box",        "..",
      ".",          "",           "box_limits_0003", "../beside",   "box_../beside", "docs/inner", "box_link",
      "bar_folder", ".box",       "box_..",          "..box_"};
  static const std::vector<std::string> endings{"",      ".txt", ".vti",   ".vtu", ".pvtu", ".pvd", ".csv",
                                                ".json", ".png", "..pvtu", "/",    "/..",   ".vtm"};
  std::string name = stems[dice() % stems.size()] + endings[dice() % endings.size()];
  return dice() % 7 == 0 ? root + "/" + name : name;
}

TEST(OutputFolderContract, ListsOfOthersDeleteNothing) {
  std::mt19937 dice(41);
  int n_lists = 0, deleted = 0;
  for (int trial = 0; trial < 50; ++trial) {
    const Folder folder;
    const std::string root = folder.path().string();
    folder.write("beside.txt", "precious");
    folder.write("beside.vti", "precious");
    fs::create_directories(folder / "out/docs");
    fs::create_directories(folder / "out/bar_folder.pvtu");
    fs::create_directories(folder / "out/box_limits");
    for (const std::string name :
         {"thesis.txt", "box_thesis.txt", "...pvtu", "..pvtu", "docs.pvtu", "box_limits.pvtu",
          "box_limits/0000.vtu", "box_limits_0003.vti", "box_thesis.csv", "box_thesis.png", "bar_coupled.vtu",
          "bar_coupled.pvd", "bar_coupled.csv", ".box.vti", "docs/inner.vtu", "docs/0000.vtu",
          "bar_folder.pvtu/0000.vtu", "box_thesis.json"})
      folder.write("out/" + name, "precious " + name);
    fs::create_symlink("../beside.vti", folder / "out/bar_link.vti");
    for (const char* scene : {"box", "bar", "..", "docs"}) { // four lists a folder
      nlohmann::ordered_json list{{"kind", dice() % 2 ? "run" : "compare"},
                                  {"maille", MAILLE_VERSION},
                                  {"scene", scene},
                                  {"scene_file", folder.scene},
                                  {"scene_text", "other"}};
      for (int i = 0; i < 40; ++i) {
        const std::string name = hostile_name(dice, root);
        list["written"].push_back(name);
        list["files"].push_back({{"file", hostile_name(dice, root)}});
        list["digests"][name] = "0123456789abcdef-8";
      }
      folder.write(fmt::format("out/{}_of_others_{}_results.json", scene[0] == '.' ? "dots" : scene, trial),
                   list.dump());
      ++n_lists;
    }
    const auto before = tree_of(root);
    const std::string command = trial % 2 ? "compare {} --reference limits" : "run {}";
    const Outcome run = test::done(fmt::format(fmt::runtime(command), folder.scene) +
                                   " --methods limits --overwrite --out " + folder.out);
    const auto after = tree_of(root);
    for (const auto& [file, content] : before)
      if (const auto left = after.find(file); left == after.end() || left->second != content) {
        ++deleted;
        ADD_FAILURE() << file;
      }
  }
  fmt::print("results_deleted_unlisted = {} of {} hostile lists\n", deleted, n_lists);
  EXPECT_EQ(deleted, 0);
  EXPECT_EQ(n_lists, 200);
}

TEST(OutputFolderContract, ALinkInTheNameOfAResultIsRefused) {
  const Folder folder;
  folder.write("victim.vti", "precious");
  fs::create_symlink("../victim.vti", fs::path(folder.out) / "box_limits_0001.vti");
  const Outcome run = test::refused("run " + folder.scene + " --methods limits --out " + folder.out);
  EXPECT_EQ(folder.text("victim.vti"), "precious");
}

TEST(OutputFolderContract, OneProcessAtATimeHasAFolder) {
  const Folder folder;
  folder.write("out/notes.txt", "mine");
  const int lock = open((folder.out + "/.maille.lock").c_str(), O_RDWR | O_CREAT, 0600);
  struct flock whole {};
  whole.l_type = F_WRLCK;
  // A lock of the open file: tree_of() opens and closes the file, which would drop one of the process.
  ASSERT_EQ(fcntl(lock, F_OFD_SETLK, &whole), 0);
  const std::string study = folder.study();
  const auto before = tree_of(folder.path());
  for (const std::string& line :
       std::vector<std::string>{"run " + folder.scene + " --methods limits --overwrite",
                                "compare " + folder.scene + " --methods limits",
                                "study " + study + " --overwrite", "study " + study + " --shard 1/2"}) {
    const Outcome run = test::refused(line + " --out " + folder.out);
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_EQ(tree_of(folder.path()), before) << line;
  }
  close(lock);
  test::done("study " + study + " --out " + folder.out);
  EXPECT_FALSE(folder.names().contains(".maille.lock"));
}

TEST(OutputFolderContract, UnfinishedFilesOfDeadProcessesGoAndLinksAreNotFollowed) {
  const Folder folder;
  std::array<char, 65> host{};
  gethostname(host.data(), host.size() - 1);
  std::string machine(host.data());
  std::replace(machine.begin(), machine.end(), '.', '_');
  const std::string dead = ".box.999999999." + machine + "-0123abcd.part.vti";
  const std::string alive = ".box." + std::to_string(getpid()) + "." + machine + "-0123abcd.part.vti";
  folder.write("out/" + dead, "half");
  folder.write("out/" + alive, "half");
  folder.write("victim.txt", "precious");
  fs::create_symlink("../victim.txt", fs::path(folder.out) / ".maille-write-test");
  test::done("run " + folder.scene + " --methods limits --out " + folder.out);
  EXPECT_FALSE(folder.names().contains(dead));
  EXPECT_TRUE(folder.names().contains(alive));
  EXPECT_EQ(folder.text("victim.txt"), "precious");
}

TEST(OutputFileContract, OnlyWhatMailleWroteMakesWay) {
  const Folder folder;
  const std::string in = folder.scene, fit = "fit " + in + " --reference relaxed --trials 2 --out m.toml",
                    compare = "compare " + in + " --methods limits,relaxed --reference relaxed ",
                    trade = "study trade " + in + " --methods limits --spacings 1 --reference limits ",
                    study = "study " + folder.study() + " --overwrite --out " + folder.out,
                    scenes = std::string(MAILLE_SCENES) + "/world/",
                    live = "live " + in + " --headless --script " +
                           folder.write("ends.csv", "time [s],event,x,y,button,name,value\n0,close,,,,,\n")
                               .string(),
                    feel = "play " + scenes + "muscle.toml " + scenes +
                           "muscle_stroked.csv --tool probe --no-clock";
  test::done("run " + in + " --methods limits --out " + folder.out);
  for (const std::string& asked :
       std::vector<std::string>{fit,
                                "run " + in + " --write m.inp",
                                "report " + folder.out + " --out m.html",
                                "study choose " + in + " --error 90% --time 60s --write c.toml",
                                "run " + in + " --json r.json",
                                "run " + in + " --json r",
                                "run " + in + " --steps 2 --picture r.png",
                                "run " + in + " --steps 2 --picture r.svg",
                                compare + "--json c.json",
                                compare + "--csv c.csv",
                                compare + "--csv c.txt",
                                "check " + in + " --json k.json",
                                "check --why " + in + " --json w.json",
                                "check library --json l.json",
                                "check muscle/soleus --json t.json",
                                trade + "--json t.json",
                                trade + "--csv t.csv",
                                "render " + in + " --out v.png",
                                live + " --record h.csv",
                                feel + " --csv f.csv"}) {
    const std::string name = asked.substr(asked.rfind(' ') + 1), file = folder.write(name, "another's\n");
    const std::string line = asked.substr(0, asked.rfind(' ') + 1) + file;
    EXPECT_TRUE(test::has(test::refused(line).err, "that Maille wrote")) << line;
    EXPECT_EQ(folder.text(name), "another's\n");
    const int code = asked == fit ? 1 : 0;
    test::done(line + " --overwrite", code);
    test::done(line, code); // its own file makes way
    EXPECT_GT(folder.text(name).size(), 20U) << line;
  }
  for (int time = 0; time < 2; ++time)
    test::done(study + " --json " + (folder / "s.json").string());
  EXPECT_TRUE(test::has(test::refused(trade + "--csv " + (folder / "c.csv").string()).err, "another file"));
}

// What a killed run leaves: files, and no list that tells what they are of. A material beside an unchanged
// scene is put there with the time of an older file.
TEST(OutputFolderContract, EveryFileThatWasReadCounts) {
  const Folder folder;
  const auto write_material = [&](const std::string& modulus) {
    return folder.write("soft.toml", "youngs_modulus = \"" + modulus + "\"\npoisson_ratio = 0.3\n");
  };
  const fs::path soft = write_material("10 kPa"), list = fs::path(folder.out) / "box_run_results.json";
  std::string text = box_of("0.1 mm");
  const std::string material = "{ youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }";
  folder.write("box.toml", text.replace(text.find(material), material.size(), "\"soft.toml\""));
  const std::string run = "run " + folder.scene + " --methods coupled --out " + folder.out;
  test::done(run);
  fs::remove(list); // as after a kill
  test::done(run);
  const auto age = fs::last_write_time(soft);
  write_material("20 kPa");
  fs::last_write_time(soft, age - std::chrono::hours(1));
  fs::remove(list);
  const std::string before = folder.text("out/box_coupled_0001.vti"), err = test::refused(run).err;
  EXPECT_TRUE(test::has(err, "soft.toml changed") && test::has(err, "--overwrite")) << err;
  EXPECT_EQ(folder.text("out/box_coupled_0001.vti"), before);
  test::done(run + " --overwrite");
  write_material("30 kPa"); // results of two kinds no longer belong together
  test::done("compare " + folder.scene + " --methods coupled,limits --reference limits --out " + folder.out);
  EXPECT_FALSE(folder.names().contains("box_coupled_0001.vti"));
}

// A killed play leaves frames, and neither a list of results nor one for ParaView.
TEST(OutputFolderContract, FramesOfAKilledPlayNeedOverwrite) {
  const Folder folder;
  const std::string world = std::string(MAILLE_SCENES) + "/world/puzzle",
                    scene = folder.write("puzzle.toml", test::text_of(world + ".toml")).string(),
                    play = "play " + scene + " " + world + "_solved.toml --no-pictures --out " + folder.out;
  for (int time = 0; time < 2; ++time) {
    test::done(play);
    for (const char* list : {"puzzle.pvd", "puzzle_play_results.json"})
      fs::remove(fs::path(folder.out) / list);
  }
  folder.write("puzzle.toml", test::text_of(world + ".toml") + "# changed\n");
  EXPECT_TRUE(test::has(test::refused(play).err, "puzzle.toml changed"));
}

TEST(OutputFileContract, EachOptionHasAFileOfItsOwn) {
  const Folder folder;
  const std::string same = (folder / "same").string(), out = (folder / "own").string();
  test::expect_refused(
      {{"compare " + folder.scene + " --methods limits --json " + same + " --csv " + same,
        "found that of --json"},
       {"run " + folder.scene + " --methods limits --out " + out + " --json " + out + "/box_run_results.json",
        "the name of a result"},
       {"compare " + folder.scene + " --methods limits --out " + out + " --csv " + out + "/box_limits.vti",
        "the name of a result"},
       {"study " + folder.study() + " --out " + out + " --json " + out + "/study_about.json",
        "the name of a result"},
       {"study trade " + folder.scene + " --out " + out + " --csv " + out + "/box_trade.csv",
        "the name of a result"}});
}

TEST(OutputFileContract, AnEmptyNameIsNoFolder) {
  const Folder folder;
  for (const std::string command : {"run", "compare", "study trade"})
    test::refused(command + " " + folder.scene + " --methods limits --out ''");
}

// A name of Latin-1, as old shares have them.
TEST(OutputFileContract, ANameThatIsNoUtf8CostsNoResult) {
  const Folder folder;
  const std::string scene = folder.write("sc\xe9ne.toml", box_of("0.1 mm")).string();
  for (const std::string command : {"run", "compare"}) {
    const Outcome run = test::done(command + " '" + scene + "' --methods limits --out " + folder.out +
                                   command + " --json " + folder.out + ".json");
    EXPECT_TRUE(nlohmann::json::accept(folder.text("out.json")));
  }
}

TEST(OutputFileContract, ATableMayNotNameAFileElsewhere) {
  const Folder folder;
  const std::string study = folder.study();
  test::done("study " + study + " --out " + folder.out);
  folder.write("victim.csv", "precious");
  std::string rows = folder.text("out/study.jsonl");
  const std::string name = "\"study\":\"study\"";
  ASSERT_NE(rows.find(name), std::string::npos);
  for (const std::string bad : {"../victim", "", "..", "a/b", ".hid", "-rf", "a\\nb", "a\u202eb"}) {
    std::string table = rows;
    table.replace(table.find(name), name.size(), "\"study\":\"" + bad + "\"");
    folder.write("tables/a.jsonl", table);
    const Outcome run = test::refused("study merge " + (folder / "tables").string() + " --out " +
                                      (folder / "whole").string());
    EXPECT_EQ(folder.text("victim.csv"), "precious") << bad;
  }
}

TEST(OutputFileContract, StudiesMayBeReplaced) {
  const Folder folder;
  const std::string study = folder.study();
  const std::string line = "study " + study + " --out " + folder.out;
  test::done(line);
  test::refused(line);
  test::done(line + " --overwrite");
  EXPECT_TRUE(folder.names().contains("study.jsonl"));
  EXPECT_FALSE(folder.names().contains("study_older.jsonl"));
  folder.write("out/study.csv", "name,phone\nmine,1\n");
  test::refused(line + " --overwrite");
  EXPECT_EQ(folder.text("out/study.csv"), "name,phone\nmine,1\n");
  test::done("run " + folder.scene + " --methods limits --out " + folder.out);
  test::refused("report " + folder.out + " --out " + folder.scene);
  EXPECT_EQ(folder.text("box.toml"), box_of("0.1 mm"));
}

// A script names pictures; what another program wrote under such a name stays.
TEST(OutputFileContract, PicturesOfScriptsReplaceOnlyMaillesOwn) {
  const Folder folder;
  const std::string line = "live " + folder.scene + " --headless --shots " + folder.out + " --script " +
                           folder
                               .write("events.csv", "time [s],event,x,y,button,name,value\n0,shot,,,,,a.png\n"
                                                    "0,close,,,,,\n")
                               .string();
  test::done(line);
  test::done(line);
  for (const std::string text : {"mine", "\x89PNG\r\n\x1a\n of another program"}) {
    folder.write("out/a.png", text);
    EXPECT_TRUE(test::has(test::refused(line).err, "--overwrite replaces it"));
    EXPECT_EQ(folder.text("out/a.png"), text);
  }
  test::done(line + " --overwrite");
  EXPECT_TRUE(folder.text("out/a.png").starts_with("\x89PNG"));
}

// A pipe gives its text once, and leads to no file.
TEST(OutputFolderContract, AScenePipedInHasResults) {
  const Folder folder;
  const std::string run = " run /dev/stdin --methods limits --out ";
  for (const char* const before : {"cat ", "< "}) {
    const Outcome piped = test::shell(before + folder.scene + (before[0] == 'c' ? " | " : " ") +
                                      MAILLE_COMMAND + run + folder.out);
    EXPECT_EQ(piped.code, 0) << piped.err;
    EXPECT_TRUE(test::has(folder.text("out/stdin_run_results.json"), "0.1 mm")) << "the scene's text";
  }
  const fs::path link = folder / "link.toml";
  fs::create_symlink(folder.scene, link);
  test::done("run " + link.string() + " --methods limits --out " + (folder / "linked").string());
  EXPECT_EQ(
      test::shell("bash -c '" MAILLE_COMMAND " run " + folder.scene + " --json >(cat > /dev/null)'").code, 0);
}

TEST(OutputFileContract, NamesOfImagesAreQuotedInNewScenes) {
  const Folder folder;
  const std::string image =
      "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 3 3\nspacings: 1 1 1\nencoding: raw\n\n" +
      std::string(36, '\1');
  for (const std::string name :
       {"a\"b.nrrd", "a\\b.nrrd", "a\nb = 1.nrrd", "a\tb\x7f.nrrd", "$HOME.nrrd", "~a.nrrd"}) {
    const fs::path file = folder.write(name, image), scene = folder / "new.toml";
    const Outcome made = test::shell("cd '" + folder.path().string() + "' && " MAILLE_COMMAND " new image '" +
                                     name + "' --out new.toml --overwrite");
    EXPECT_EQ(made.code, 0) << name << made.err;
    EXPECT_EQ(maille_command("check " + scene.string()).code, 0) << name << folder.text("new.toml");
  }
}

} // namespace
} // namespace maille
