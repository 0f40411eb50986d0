/// What commands write, and what they must not touch.

#include "studies/commands/run_command.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <set>

#include <unistd.h>

namespace maille {
namespace {

namespace fs = std::filesystem;
using test::maille_command;
using test::Outcome;

std::string box_of(const std::string& move) {
  return R"([specimen]
shape = "box"
cells = [3, 2, 2]
spacing = "1 mm"
material = { youngs_modulus = "10 kPa", poisson_ratio = 0.3 }
[[hold]]
where = "x-"
[[move]]
where = "x+"
by = [")" +
         move +
         R"(", "0 mm", "0 mm"]
)";
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
  std::string text(const fs::path& file) const {
    std::ifstream stream(path() / file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
};

TEST(OutputFolderContract, ResultsOfTheSameSceneAreReplacedAsASet) {
  const Folder folder;
  ASSERT_EQ(maille_command("run " + folder.scene + " --methods coupled --steps 4 --out " + folder.out).code,
            0);
  ASSERT_EQ(folder.names().size(), 5U + 1 + 1 + 1)
      << "rest, four steps, their list, their forces, the results";
  ASSERT_EQ(maille_command("run " + folder.scene + " --methods limits --out " + folder.out).code, 0);
  EXPECT_EQ(folder.names(), (std::set<std::string>{"box_limits_0001.vti", "box_run_results.json"}));
  // Two kinds of results of one text lie side by side; of another text they would not belong together.
  ASSERT_EQ(maille_command("compare " + folder.scene + " --methods limits,fem_q1 --out " + folder.out).code,
            0);
  EXPECT_TRUE(folder.names().contains("box_limits_0001.vti"));
  folder.write("box.toml", box_of("0.3 mm"));
  ASSERT_EQ(maille_command("compare " + folder.scene + " --methods limits,fem_q1 --out " + folder.out).code,
            0);
  EXPECT_EQ(folder.names(),
            (std::set<std::string>{"box.vtm", "box_compare.csv", "box_compare.json",
                                   "box_compare_results.json", "box_fem_q1.vti", "box_limits.vti"}));
}

TEST(OutputFolderContract, ResultsOfAnotherSceneOrVersionAreRefusedUnlessToBeReplaced) {
  const Folder folder;
  ASSERT_EQ(maille_command("run " + folder.scene + " --methods limits --out " + folder.out).code, 0);
  folder.write("out/notes.txt", "mine");
  const std::set<std::string> before = folder.names();
  const Outcome refused = maille_command("compare " + folder.other + " --methods limits --out " + folder.out);
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("--overwrite"), std::string::npos) << refused.err;
  EXPECT_EQ(folder.names(), before);
  ASSERT_EQ(maille_command("run " + folder.other + " --methods limits --overwrite --out " + folder.out).code,
            0);
  EXPECT_EQ(folder.names(),
            (std::set<std::string>{"bar_limits_0001.vti", "bar_run_results.json", "notes.txt"}));

  auto results = nlohmann::ordered_json::parse(folder.text("out/bar_run_results.json"));
  results["maille"] = "0.0.1";
  folder.write("out/bar_run_results.json", results.dump());
  EXPECT_EQ(maille_command("run " + folder.other + " --methods limits --out " + folder.out).code, 2);
}

TEST(OutputFolderContract, WhatAListNamesElsewhereIsNotTouched) {
  const Folder folder;
  folder.write("victim.vti", "precious");
  folder.write("out/box_run_results.json",
               R"({"kind":"run","maille":")" MAILLE_VERSION
               R"(","scene":"box","scene_text":"","scene_file":")" +
                   folder.scene +
                   R"(","written":["../victim.vti","/etc/hostname"],"files":[{"file":"../victim.vti"}]})");
  ASSERT_EQ(maille_command("run " + folder.scene + " --methods limits --out " + folder.out).code, 0);
  EXPECT_EQ(folder.text("victim.vti"), "precious");
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
  ASSERT_EQ(maille_command("run " + folder.scene + " --methods limits --out " + folder.out).code, 0);
  EXPECT_FALSE(folder.names().contains(dead));
  EXPECT_TRUE(folder.names().contains(alive));
  EXPECT_EQ(folder.text("victim.txt"), "precious");
}

TEST(OutputFileContract, NoOptionPutsAResultInThePlaceOfWhatIsRead) {
  const Folder folder;
  folder.write("soft.toml", "youngs_modulus = \"10 kPa\"\npoisson_ratio = 0.3\n");
  std::string text = box_of("0.1 mm");
  const std::string material = "{ youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }";
  text.replace(text.find(material), material.size(), "\"soft.toml\"");
  const std::string named = folder.write("named.toml", text).string();
  const std::string soft = (folder / "soft.toml").string();
  fs::create_hard_link(folder.scene, folder / "link.csv");
  const std::string csv = (folder / "link.csv").string();
  for (const std::string& line : std::vector<std::string>{
           "compare " + folder.scene + " --methods limits --csv " + folder.scene,
           "compare " + folder.scene + " --methods limits --csv " + csv,
           "export " + folder.scene + " --out " + csv, "compare " + named + " --methods limits --csv " + soft,
           "trade " + folder.scene + " --csv " + csv,
           "fit " + folder.scene + " " + folder.other + " --out " + folder.scene,
           "fit " + folder.scene + " " + folder.other + " --out " + soft,
           "explain " + folder.scene + " --json " + csv}) {
    const std::string before = folder.text("box.toml"), soft_before = folder.text("soft.toml");
    const Outcome run = maille_command(line);
    EXPECT_EQ(run.code, 2) << line << run.err;
    EXPECT_EQ(folder.text("box.toml"), before) << line;
    EXPECT_EQ(folder.text("soft.toml"), soft_before) << line;
  }
}

TEST(OutputFileContract, AnEmptyNameIsNoFolder) {
  const Folder folder;
  for (const std::string command : {"run", "compare", "trade"})
    EXPECT_EQ(maille_command(command + " " + folder.scene + " --methods limits --out ''").code, 2) << command;
}

// A name of Latin-1, as old shares have them.
TEST(OutputFileContract, ANameThatIsNoUtf8CostsNoResult) {
  const Folder folder;
  const std::string scene = folder.write("sc\xe9ne.toml", box_of("0.1 mm")).string();
  for (const std::string command : {"run", "compare"}) {
    const Outcome run = maille_command(command + " '" + scene + "' --methods limits --out " + folder.out +
                                       command + " --json " + folder.out + ".json");
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_TRUE(nlohmann::json::accept(folder.text("out.json")));
  }
}

TEST(OutputFileContract, ATableMayNotNameAFileElsewhere) {
  const Folder folder;
  const std::string study = folder
                                .write("study.toml", "scene = \"box.toml\"\nmethods = [\"limits\"]\n"
                                                     "reference = \"none\"\n[[parameter]]\n"
                                                     "key = \"move.0.by.0\"\nvalues = [\"0.1 mm\"]\n")
                                .string();
  ASSERT_EQ(maille_command("study " + study + " --out " + folder.out).code, 0);
  folder.write("victim.csv", "precious");
  std::string rows = folder.text("out/study.jsonl");
  const std::string name = "\"study\":\"study\"";
  ASSERT_NE(rows.find(name), std::string::npos);
  for (const std::string bad : {"../victim", "", "..", "a/b"}) {
    std::string table = rows;
    table.replace(table.find(name), name.size(), "\"study\":\"" + bad + "\"");
    folder.write("tables/a.jsonl", table);
    const Outcome run =
        maille_command("merge " + (folder / "tables").string() + " --out " + (folder / "whole").string());
    EXPECT_EQ(run.code, 2) << bad << run.err;
    EXPECT_EQ(folder.text("victim.csv"), "precious") << bad;
  }
}

TEST(OutputFileContract, StudiesMayBeReplaced) {
  const Folder folder;
  const std::string study = folder
                                .write("study.toml", "scene = \"box.toml\"\nmethods = [\"limits\"]\n"
                                                     "reference = \"none\"\n[[parameter]]\n"
                                                     "key = \"move.0.by.0\"\nvalues = [\"0.1 mm\"]\n")
                                .string();
  const std::string line = "study " + study + " --out " + folder.out;
  ASSERT_EQ(maille_command(line).code, 0);
  EXPECT_EQ(maille_command(line).code, 2);
  EXPECT_EQ(maille_command(line + " --overwrite").code, 0);
  EXPECT_TRUE(folder.names().contains("study.jsonl"));
  EXPECT_FALSE(folder.names().contains("study_older.jsonl"));
}

} // namespace
} // namespace maille
