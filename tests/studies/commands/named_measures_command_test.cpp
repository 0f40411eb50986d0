/// Measures as `maille run`, `compare`, `trade` and `check` tell them.

#include "maille/scene/csv.hpp"
#include "studies/commands/command_scenes.hpp"
#include "studies/commands/run_command.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace maille {
namespace {

using nlohmann::json;
using test::maille_command;
using test::Outcome;

const std::string bar = test::pulled_bar + R"([[measure]]
name = "pull"
force = "move[1]"
[[measure]]
name = "half"
force = { section = { point = ["2 mm", 0, 0], normal = [1, 0, 0] } }
component = "normal"
[[measure]]
name = "longer"
length = [[0, "1 mm", "1 mm"], ["4 mm", "1 mm", "1 mm"]]
kind = "relative"
[[measure]]
name = "line"
displacement = { along = [[0, 0, 0], ["4 mm", 0, 0]], points = 5 }
component = "x"
)";

struct Folder {
  test::TemporaryFolder folder;
  std::string path(const std::string& name) const { return (folder / name).string(); }
  std::string scene(const std::string& more = "") const {
    std::ofstream(path("bar.toml")) << bar << more;
    return path("bar.toml");
  }
};

std::vector<std::vector<std::string>> csv_in(const std::string& text) {
  std::vector<std::vector<std::string>> rows;
  for (CsvRecords records(text); records.next();)
    rows.push_back(records.cells());
  return rows;
}

double cell(const std::vector<std::vector<std::string>>& table, std::size_t row, const std::string& column) {
  const auto found = std::ranges::find(table.at(0), column);
  EXPECT_NE(found, table.at(0).end()) << column;
  const std::string& text = table.at(row).at(static_cast<std::size_t>(found - table[0].begin()));
  return text.empty() ? NAN : std::stod(text);
}

// Truth: Hooke's law of a bar that is pulled.
TEST(NamedMeasuresCommandAnalytic, RunTellsThemByName) {
  const Folder folder;
  const Outcome run = maille_command("run " + folder.scene() + " --methods coupled,limits --json");
  ASSERT_EQ(run.code, 0) << run.err;
  const json rows = json::parse(run.out)["results"];
  const json& found = rows[0]["measures"];
  ASSERT_EQ(found.size(), 4u);
  EXPECT_EQ(found[0]["name"], "pull");
  EXPECT_EQ(found[0]["unit"], "N");
  EXPECT_NEAR(found[0]["value"], 2e-3, 1e-7);
  EXPECT_NEAR(found[0]["vector"][0], 2e-3, 1e-7);
  EXPECT_NEAR(found[1]["value"], 2e-3, 1e-7);
  EXPECT_FALSE(found[1].contains("vector"));
  EXPECT_NEAR(found[2]["value"], 0.05, 1e-6);
  ASSERT_EQ(found[3]["line"].size(), 5u);
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_NEAR(found[3]["line"][i]["value"], 5e-5 * static_cast<double>(i), 1e-9);
  EXPECT_TRUE(rows[1]["measures"][0]["value"].is_null());
  EXPECT_EQ(rows[1]["measures"][0]["why_not"], "limits knows no forces");
  EXPECT_NEAR(rows[1]["measures"][2]["value"], 0.05, 1e-6);
  EXPECT_NE(maille_command("run " + folder.scene()).out.find("pull             coupled"), std::string::npos);
}

TEST(NamedMeasuresCommandAnalytic, StepsHaveThem) {
  const Folder folder;
  const Outcome run = maille_command("run " + folder.scene() + " --steps 4 --out " + folder.path("out"));
  ASSERT_EQ(run.code, 0) << run.err;
  const auto steps = csv_in(test::text_of(folder.path("out/bar_coupled_measures.csv")));
  ASSERT_EQ(steps.size(), 5u);
  for (std::size_t step = 1; step <= 4; ++step) {
    EXPECT_NEAR(cell(steps, step, "pull_x"), 5e-4 * static_cast<double>(step), 1e-7);
    EXPECT_NEAR(cell(steps, step, "longer"), 0.0125 * static_cast<double>(step), 1e-6);
  }
  const auto line = csv_in(test::text_of(folder.path("out/bar_coupled_line.csv")));
  ASSERT_EQ(line.size(), 6u);
  EXPECT_EQ(line[0], (std::vector<std::string>{"along_m", "x_m", "y_m", "z_m", "line"}));
  EXPECT_NEAR(cell(line, 5, "line"), 2e-4, 1e-9);
}

TEST(NamedMeasuresCommandAnalytic, CompareHasTheirErrors) {
  const Folder folder;
  const Outcome run =
      maille_command("compare " + folder.scene() + " --methods limits,relaxed,fem_q1 --json " +
                     folder.path("c.json") + " --csv " + folder.path("c.csv"));
  ASSERT_EQ(run.code, 0) << run.err;
  const json rows = json::parse(test::text_of(folder.path("c.json")))["results"];
  const auto table = csv_in(test::text_of(folder.path("c.csv")));
  ASSERT_EQ(table.size(), 4u);
  for (const auto& line : table)
    EXPECT_EQ(line.size(), table[0].size());
  for (std::size_t i = 0; i < 3; ++i) {
    const json& row = rows[i];
    EXPECT_NEAR(cell(table, i + 1, "longer"), row["measures"][2]["value"], 1e-9);
    if (row["method"] == "fem_q1") {
      EXPECT_NEAR(cell(table, i + 1, "pull"), 2e-3, 1e-7);
      EXPECT_TRUE(std::isnan(cell(table, i + 1, "pull_error")));
      EXPECT_FALSE(row.contains("error"));
    } else if (row["method"] == "limits") {
      EXPECT_FALSE(row["error"]["measures"].contains("pull"));
      EXPECT_LT(row["error"]["measures"]["longer"], 1e-6);
    } else {
      // It knows no Poisson effect: lambda + 2 mu in place of E, its own weights included.
      const double pull = row["measures"][0]["value"], truth = rows[2]["measures"][0]["value"];
      EXPECT_NEAR(row["error"]["measures"]["pull"], std::abs(pull / truth - 1), 1e-6);
      EXPECT_GT(row["error"]["measures"]["pull"], 0.1);
      EXPECT_NEAR(cell(table, i + 1, "pull_error"), row["error"]["measures"]["pull"], 1e-6);
    }
  }
}

TEST(NamedMeasuresCommandAnalytic, TradeMeasuresEveryLattice) {
  const Folder folder;
  const Outcome run =
      maille_command("trade " + folder.scene() + " --methods coupled --spacings 2,1,0.5 --tolerances 1e-4 " +
                     "--reference fem_q1 --json " + folder.path("t.json") + " --csv " + folder.path("t.csv"));
  ASSERT_EQ(run.code, 0) << run.err;
  const json rows = json::parse(test::text_of(folder.path("t.json")))["rows"];
  const auto table = csv_in(test::text_of(folder.path("t.csv")));
  ASSERT_EQ(rows.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(rows[i]["measures"][0]["value"], 2e-3, 1e-6) << "a uniform strain on any lattice";
    EXPECT_LT(rows[i]["error"]["measures"]["pull"], 1e-3);
    EXPECT_NEAR(cell(table, i + 1, "pull"), 2e-3, 1e-6);
    EXPECT_EQ(table[i + 1].size(), table[0].size());
  }
}

/// Truth: a uniform strain, whose force every lattice gives alike.
TEST(NamedMeasuresCommandAnalytic, ChooseChoosesByTheirErrors) {
  const Folder folder;
  const Outcome run =
      maille_command("choose " + folder.scene() + " --error 5% --time 10s --of pull --json -");
  const json choice = json::parse(run.out);
  EXPECT_EQ(choice["wish"]["of"], "pull");
  EXPECT_LT(choice["probes"]["difference"], 1e-2);
  const Outcome unknown = maille_command("choose " + folder.scene() + " --error 5% --time 10s --of pul");
  EXPECT_EQ(unknown.code, 2);
  EXPECT_NE(unknown.err.find("did you mean \"pull\"?"), std::string::npos) << unknown.err;
}

TEST(NamedMeasuresCommandContract, CheckListsThemAndFaultsEndWithTwo) {
  const Folder folder;
  const Outcome good = maille_command("check " + folder.scene());
  ASSERT_EQ(good.code, 0) << good.err;
  EXPECT_NE(good.out.find("measure pull: force on move[1]"), std::string::npos) << good.out;
  const json listed = json::parse(maille_command("check " + folder.scene() + " --json").out);
  EXPECT_EQ(listed["measures"][2]["name"], "longer");
  const std::string faulty = "[[measure]]\nname = \"pull\"\nforce = \"move[7]\"\n";
  for (const char* command : {"check ", "run ", "compare "}) {
    const Outcome bad = maille_command(command + folder.scene(faulty));
    EXPECT_EQ(bad.code, 2) << command;
    EXPECT_NE(bad.err.find("measure[5].force"), std::string::npos) << bad.err;
    EXPECT_NE(bad.err.find("measure[5].name"), std::string::npos) << bad.err;
  }
}

} // namespace
} // namespace maille
