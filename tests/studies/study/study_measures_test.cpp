/// Measures of scenes as columns of studies.
#include "compare/comparison_columns.hpp"
#include "studies/commands/command_scenes.hpp"
#include "study/measures.hpp"
#include "study/plan/study_table.hpp"
#include "study/study_run.hpp"
#include "study/table_files.hpp"
#include "support/mistake.hpp"
#include "support/temporary_folder.hpp"
#include "trade/measure.hpp"

#include <gtest/gtest.h>

namespace maille::studies {
namespace {

/// A bar that may contract sideways.
const std::string bar = test::pulled_bar + R"([[measure]]
name = "pull"
force = "move[1]"
[[measure]]
name = "longer"
length = [[0, "1 mm", "1 mm"], ["4 mm", "1 mm", "1 mm"]]
kind = "change"
)";

constexpr const char* study = R"(
scene = "bar.toml"
methods = ["limits", "coupled"]
reference = "coupled"
[[parameter]]
key = "specimen.material.youngs_modulus"
values = ["10 kPa", "20 kPa"]
)";

double measure_of(const StudyRow& row, const std::string& name) {
  const auto found = std::ranges::find(row.measures, name, &StudyMeasure::name);
  return found == row.measures.end() ? NAN : found->value.value_or(NAN);
}

struct Folder {
  test::TemporaryFolder folder;
  StudyFile read(const std::string& scene = bar, const char* text = study) const {
    folder.write("bar.toml", scene);
    return read_study(folder.write("study.toml", text));
  }
};

// Truth: Hooke's law: strain 5 %, 4 mm^2, so that 10 kPa take 2 mN; a method without forces has none.
TEST(StudyMeasuresAnalytic, AreColumnsOfEveryRow) {
  const Folder folder;
  const StudyFile read = folder.read();
  std::vector<std::string> names;
  for (const MeasureColumn& column : read.measures)
    names.push_back(column.name + "|" + column.unit);
  EXPECT_EQ(names, (std::vector<std::string>{"pull|N", "pull_x|N", "pull_y|N", "pull_z|N", "pull_error|",
                                             "longer|m", "longer_error|"}));
  StudyOptions options;
  options.out = folder.folder.path();
  for (const StudyCase& one : cases(read))
    for (const StudyRow& row : run_case(read, one, {"limits", "coupled"}, {}, options)) {
      ASSERT_EQ(row.measures.size(), 7u);
      EXPECT_NEAR(measure_of(row, "longer"), 0.2e-3, 1e-8);
      EXPECT_EQ(std::isnan(measure_of(row, "pull")), row.method == "limits");
      EXPECT_EQ(std::isnan(measure_of(row, "longer_error")), row.method == "coupled")
          << "the reference has no error of its own";
      if (row.method == "coupled") {
        EXPECT_NEAR(measure_of(row, "pull_x"), 2e-3 * one.number, 1e-6);
        EXPECT_NEAR(measure_of(row, "pull"), 2e-3 * one.number, 1e-6);
      }
    }
}

StudyRow row_with(std::vector<StudyMeasure> measures) {
  StudyRow row;
  row.study = "s";
  row.scene = "bar";
  row.number = row.n_cases = 1;
  row.parameters = {{"ratio [kPa]", 3.0}, {"tissue", "muscle/soleus"}};
  row.method = "coupled";
  row.measures = std::move(measures);
  return row;
}

void expect_same_measures(const StudyRow& row, const StudyRow& other, bool with_units) {
  ASSERT_EQ(row.measures.size(), other.measures.size());
  for (std::size_t i = 0; i < row.measures.size(); ++i) {
    EXPECT_EQ(row.measures[i].name, other.measures[i].name);
    EXPECT_EQ(row.measures[i].value, other.measures[i].value);
    if (with_units) {
      EXPECT_EQ(row.measures[i].unit, other.measures[i].unit);
    }
  }
  EXPECT_EQ(row.parameters, other.parameters);
}

TEST(StudyMeasuresContract, AreReadBackToTheBit) {
  const StudyRow row =
      row_with({{"pull", "N", 0.1 + 0.2}, {"pull_error", "", {}}, {"angle_1", "rad", -1e-300}});
  expect_same_measures(row, row_from_json(json_line(row)), true);
  const auto table = parse_study_csv(csv_header(row) + csv_line(row), "t.csv");
  ASSERT_EQ(table.rows.size(), 1u);
  expect_same_measures(row, table.rows[0], false);
  const StudyRow plain = row_with({});
  EXPECT_EQ(json_line(plain).find("measure"), std::string::npos);
  EXPECT_TRUE(row_from_json(json_line(plain)).measures.empty());
}

TEST(StudyMeasuresContract, RowsOfOneTableHaveTheSameColumns) {
  const auto rows = with_same_measures(
      {row_with({{"a", "N", 1.0}}), row_with({{"b", "m", 2.0}, {"a", "N", {}}}), row_with({})});
  for (const StudyRow& row : rows) {
    ASSERT_EQ(row.measures.size(), 2u);
    EXPECT_EQ(row.measures[0].name, "a");
    EXPECT_EQ(row.measures[1].name, "b");
    EXPECT_EQ(csv_header(row), csv_header(rows[0]));
  }
  EXPECT_EQ(rows[0].measures[0].value, 1.0);
  EXPECT_EQ(rows[1].measures[1].value, 2.0);
  EXPECT_FALSE(rows[2].measures[0].value);
}

TEST(StudyMeasuresContract, AParameterOfTheSameNameIsAFault) {
  const Folder folder;
  const auto faults = test::faults_found_by([&] {
    folder.read(bar, "scene = \"bar.toml\"\nmethods = [\"coupled\"]\n[[parameter]]\nkey = "
                     "\"specimen.material.poisson_ratio\"\nvalues = [0.2, 0.3]\nlabel = \"pull_x\"\n");
  });
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_NE(faults[0].found.find("pull_x"), std::string::npos);
}

TEST(StudyMeasuresContract, TheSummaryHasThem) {
  const std::string text =
      measures_in_words({row_with({{"pull", "N", 1.0}, {"pull_x", "N", 1.0}, {"pull_error", "", 0.5}}),
                         row_with({{"pull", "N", 3.0}, {"pull_x", "N", 3.0}, {"pull_error", "", 0.25}})});
  EXPECT_NE(text.find("1 N"), std::string::npos) << text;
  EXPECT_NE(text.find("3 N"), std::string::npos) << text;
  EXPECT_NE(text.find("50 %"), std::string::npos) << text;
  EXPECT_EQ(text.find("pull_x"), std::string::npos) << text;
  EXPECT_EQ(measures_in_words({row_with({})}), "");
}

// A measure of the name of a column would hide it, or be hidden by it.
TEST(MeasureNamesContract, NoColumnOfResultsCanBeTaken) {
  std::vector<std::string> names = columns_of_comparison().csv_names();
  for (const auto& more : {columns_of_trade().csv_names(), study_columns()})
    names.insert(names.end(), more.begin(), more.end());
  EXPECT_GT(names.size(), 60u);
  for (const std::string& name : names)
    EXPECT_TRUE(is_reserved_name(name)) << name << " is missing in is_reserved_name";
  EXPECT_FALSE(is_reserved_name("pull"));
}

} // namespace
} // namespace maille::studies
