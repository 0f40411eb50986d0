/// Tables as files: written, torn, read, put together.

#include "compare/comparison_columns.hpp"
#include "maille/base/csv.hpp"
#include "studies/commands/command_scenes.hpp"
#include "studies/study/study_scenes.hpp"
#include "study/plan/study_table.hpp"
#include "study/study_run.hpp"
#include "study/table_files.hpp"
#include "support/kit.hpp"
#include "text.hpp"
#include "trade/measure.hpp"

namespace maille::studies {
namespace {

StudyRow row(int number, const std::string& method, const std::string& hash = "h") {
  StudyRow one;
  one.study = "s";
  one.scene = "strip";
  one.number = number;
  one.n_cases = 3;
  one.parameters = {{"E, fibre [kPa]", 0.1 + number}, {"by", "[\"1 mm\", 0]"}};
  one.method = method;
  one.status = Status::clamped;
  one.message = "first\nsecond, with \"quotes\"";
  one.error = ErrorNorms{1.0 / 3, std::numeric_limits<double>::infinity(), 1e-300};
  one.seconds = {0.1, 0.2};
  one.total_seconds = 0.30000000000000004;
  one.repetitions = 3;
  one.timing = Timing::busy;
  one.processor_share = 0.5;
  one.bytes = 9'007'199'254'740'991;
  one.iterations = 7;
  one.limit_violation = 0.25;
  one.reference = "best";
  one.reference_error = ErrorNorms{0.01, 0.02, 0.03};
  one.algorithm = "multigrid";
  one.dimension = 2;
  one.cells = 32;
  one.nodes = 45;
  one.threads = 2;
  one.maille = "0.1.0";
  one.hash = hash;
  one.vtk = "s_0001_limits.vti";
  return one;
}

std::string lines(const std::vector<StudyRow>& rows) {
  std::string text;
  for (const StudyRow& one : rows)
    text += json_line(one) + "\n";
  return text;
}

StudyRow read_back(const std::string& line) {
  return parse_study_table(line + "\n", "t.jsonl").rows.at(0);
}

TEST(StudyTableContract, RowsReadBackToTheBit) {
  StudyRow bare = row(2, "fem_q1");
  bare.error.reset();
  bare.limit_violation.reset();
  bare.reference_error.reset();
  const std::vector<StudyRow> rows{row(1, "limits"), bare};
  const StudyTable read = parse_study_table(lines(rows), "t.jsonl");
  EXPECT_EQ(lines(read.rows), lines(rows));
  EXPECT_EQ(columns_of_study().csv(read.rows), columns_of_study().csv(rows));
  EXPECT_EQ(read.rows[0].total_seconds, rows[0].total_seconds);
  EXPECT_EQ(read.rows[0].error->relative_l2, 1.0 / 3);
  EXPECT_FALSE(read.rows[1].error);
}

// RFC 4180: what holds a comma, a quote or an end of line, of any kind, is in quotes.
TEST(CsvTextContract, IsQuotedWhereItMustBe) {
  EXPECT_EQ(csv_text("a bar"), "a bar");
  EXPECT_EQ(csv_text("a, b"), "\"a, b\"");
  EXPECT_EQ(csv_text("a \"bar\""), "\"a \"\"bar\"\"\"");
  EXPECT_EQ(csv_text("a\nb"), "\"a\nb\"");
  EXPECT_EQ(csv_text("a\rb"), "\"a\rb\"");
}

// A spreadsheet would do what such a cell says.
TEST(CsvTextContract, NoTextIsAFormula) {
  for (const char* text : {"=1+1", "@SUM(A1)", "+1", "-A1", "-2+cmd|x", "\r=1", "-1 mm"})
    EXPECT_TRUE(test::has(csv_text(text), std::string("'") + text));
  for (const char* text : {"-1.5e-3", "-.5", "-inf", "a=b", "'quoted'", "-"})
    EXPECT_EQ(csv_text(text), text);
  for (const std::string text : {"=1+1", "'=HYPERLINK(A1)", "@label"})
    EXPECT_EQ(without_guard(csv_text(text)), text);
}

TEST(StudyTableContract, ATornLastLineIsLeftOut) {
  const std::string whole = lines({row(1, "limits"), row(1, "relaxed")});
  const std::size_t first = lines({row(1, "limits")}).size();
  for (const std::size_t size : {first + 1, whole.size() - 1}) {
    const StudyTable table = parse_study_table(whole.substr(0, size), "t.jsonl");
    EXPECT_EQ(table.rows.size(), 1u);
    EXPECT_TRUE(table.is_torn);
  }
  EXPECT_FALSE(parse_study_table(whole.substr(0, first), "t.jsonl").is_torn);
}

TEST(StudyTableContract, AFaultyLineInTheMiddleIsAFaultWithItsLine) {
  const auto faults = test::faults_found_by([] {
    parse_study_table(json_line(row(1, "limits")) + "\n{}\n" + lines({row(2, "limits")}), "t.jsonl");
  });
  ASSERT_FALSE(faults.empty());
  EXPECT_EQ(faults.front().line, 2);
  EXPECT_TRUE(
      test::says_only(test::faults_found_by([] { read_study_table("t.csv"); }), {.expected = ".jsonl"}));
}

TEST(StudyTableContract, AFileOfFaultsEndsAtAHundred) {
  std::string text;
  for (int i = 0; i < 1000; ++i)
    text += "[]\n";
  EXPECT_EQ(test::faults_found_by([&] { parse_study_table(text, "t.jsonl"); }).size(), 100u);
}

TEST(StudyTableContract, NumbersThatAreNotFiniteReadBack) {
  StudyRow infinite = row(1, "limits");
  infinite.seconds.setup = infinite.total_seconds = std::numeric_limits<double>::infinity();
  infinite.parameters = {{"size", "inf"}};
  const std::string line = json_line(infinite);
  EXPECT_EQ(json_line(read_back(line)), line);
}

// Conversions of such numbers would be undefined.
TEST(StudyTableContract, NumbersThatNoRowCanHaveAreFaults) {
  const std::string line = json_line(row(1, "limits"));
  for (const std::string number :
       {"1e300", "4294967296", "-9223372036854775809", "18446744073709551615", "1.5", "null"}) {
    std::string faulty = line;
    const std::string key = "\"case\":";
    faulty.replace(faulty.find(key) + key.size(), 1, number);
    EXPECT_THROW(parse_study_table(faulty + "\n" + line + "\n", "t.jsonl"), InputError) << number;
  }
}

TEST(StudyTableContract, PartsAreMergedOnceAndMissingCasesCounted) {
  const test::TemporaryFolder folder;
  folder.write("a.jsonl", lines({row(3, "limits"), row(3, "fem_q1")}));
  folder.write("b.jsonl", lines({row(1, "limits"), row(1, "fem_q1"), row(3, "limits")}));
  const auto merged = merge_study_tables({folder / "a.jsonl", folder / "b.jsonl"}, folder / "out");
  ASSERT_EQ(merged.size(), 1u);
  EXPECT_EQ(merged[0].study, "s");
  EXPECT_EQ(merged[0].missing, 1);
  ASSERT_EQ(merged[0].rows.size(), 4u);
  EXPECT_EQ(merged[0].rows[0].number, 1);
  EXPECT_EQ(merged[0].rows[1].method, "fem_q1");
  EXPECT_EQ(merged[0].rows[0].vtk, "../s_0001_limits.vti") << "as seen from the table's folder";
}

TEST(StudyTableContract, PartsOfDifferentStudiesOfOneNameAreAFault) {
  const test::TemporaryFolder folder;
  folder.write("a.jsonl", lines({row(1, "limits", "one")}));
  folder.write("b.jsonl", lines({row(1, "limits", "two")}));
  EXPECT_THROW(merge_study_tables({folder / "a.jsonl", folder / "b.jsonl"}, folder.path()), InputError);
}

TEST(StudyTableContract, FilesForParaViewStandInOneCollection) {
  const test::TemporaryFolder folder;
  const auto files =
      write_study_table({row(1, "limits"), row(1, "relaxed"), row(3, "relaxed")}, folder / "s");
  ASSERT_EQ(files.size(), 3u);
  const std::string text = test::text_of(files[2]);
  EXPECT_TRUE(test::has(text, "timestep=\"3\" part=\"1\" file=\"s_0001_limits.vti\""));
}

/// Measures of scenes as columns of studies.

/// A bar that may contract sideways.
const std::string bar =
    test::pulled_bar + test::measure_text("pull", "force = \"move[1]\"") +
    test::measure_text("longer", "length = [[0, \"1 mm\", \"1 mm\"], [\"4 mm\", \"1 mm\", \"1 mm\"]]\n"
                                 "kind = \"change\"");

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

void expect_same_measures(const StudyRow& row, const StudyRow& other) {
  ASSERT_EQ(row.measures.size(), other.measures.size());
  for (std::size_t i = 0; i < row.measures.size(); ++i) {
    EXPECT_EQ(row.measures[i].name, other.measures[i].name);
    EXPECT_EQ(row.measures[i].value, other.measures[i].value);
    EXPECT_EQ(row.measures[i].unit, other.measures[i].unit);
  }
  EXPECT_EQ(row.parameters, other.parameters);
}

TEST(StudyMeasuresContract, AreReadBackToTheBit) {
  const StudyRow row =
      row_with({{"pull", "N", 0.1 + 0.2}, {"pull_error", "", {}}, {"angle_1", "rad", -1e-300}});
  expect_same_measures(row, read_back(json_line(row)));
  const StudyRow plain = row_with({});
  EXPECT_FALSE(test::has(json_line(plain), "measure"));
  EXPECT_TRUE(read_back(json_line(plain)).measures.empty());
}

TEST(StudyMeasuresContract, RowsOfOneTableHaveTheSameColumns) {
  const test::TemporaryFolder folder;
  write_study_table({row_with({{"a", "N", 1.0}}), row_with({{"b", "m", 2.0}, {"a", "N", {}}}), row_with({})},
                    folder / "s");
  const std::vector<StudyRow> rows = read_study_table(folder / "s.jsonl").rows;
  ASSERT_EQ(rows.size(), 3u);
  for (const StudyRow& row : rows) {
    ASSERT_EQ(row.measures.size(), 2u);
    EXPECT_EQ(row.measures[0].name, "a");
    EXPECT_EQ(row.measures[1].name, "b");
    EXPECT_EQ(columns_of_study().csv_header(row), columns_of_study().csv_header(rows[0]));
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
  EXPECT_TRUE(test::says_only(faults, {.found = "pull_x"}));
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
