/// `maille study` and `maille study merge` as outside scripts see them: killed, resumed, in parts.

#include "studies/commands/run_command.hpp"
#include "studies/study/study_scenes.hpp"
#include "study/plan/study_table.hpp"
#include "study/table_files.hpp"
#include "support/kit.hpp"

#include <nlohmann/json.hpp>

namespace maille::studies {
namespace {

namespace fs = std::filesystem;
using test::maille_command;
using test::Outcome;
using test::parameter;

class StudyCommandContract : public testing::Test {
protected:
  std::string study(const std::string& text, const std::string& name = "study") const {
    return folder.write(name + ".toml", text).string();
  }
  /// Every row without what differs from run to run, sorted.
  static std::vector<std::string> rows(const fs::path& table) {
    std::vector<std::string> lines;
    for (StudyRow row : read_study_table(table).rows) {
      row.seconds = {};
      row.total_seconds = row.processor_share = row.load_average = 0;
      row.timing = Timing::alone;
      row.vtk = fs::path(row.vtk).filename().string();
      lines.push_back(json_line(row));
    }
    std::sort(lines.begin(), lines.end());
    return lines;
  }
  /// Whether the copy for other programs has the rows of the table, in their order.
  static void expect_copied(const fs::path& table) {
    const auto rows = read_study_table(table).rows;
    EXPECT_EQ(test::text_of(fs::path(table).replace_extension(".csv")), columns_of_study().csv(rows));
  }
  const test::StudyFolder folder;
  const std::string moves =
      test::small_head + parameter("move.0.by.0", "range = [\"0.1 mm\", \"0.8 mm\"]\ncount = 8");
};

TEST_F(StudyCommandContract, OneRowACaseAndMethodWithItsFigures) {
  const fs::path out = folder / "out";
  const Outcome run = test::done("study " +
                                 study(moves + "[[parameter]]\nkey = \"specimen.fibre.angle\"\n"
                                               "values = [\"0 deg\"]\n") +
                                 " --out " + out.string());
  const auto table = read_study_table(out / "study.jsonl").rows;
  ASSERT_EQ(table.size(), 8u * 3);
  EXPECT_EQ(table[0].method, "limits");
  EXPECT_EQ(table[2].method, "fem_q1");
  EXPECT_FALSE(table[2].error) << "the reference itself";
  EXPECT_GT(table[0].error->relative_l2, 0.01) << "limits know no Poisson effect";
  EXPECT_EQ(table[21].parameters[0].first, "move.0.by.0 [mm]");
  EXPECT_EQ(std::get<double>(table[21].parameters[0].second), 0.8);
  EXPECT_EQ(table[0].nodes, 45);
  expect_copied(out / "study.jsonl");
}

TEST_F(StudyCommandContract, AFailingCaseIsARowWithItsMessage) {
  // The energy is positive only where nu_fibre^2 < E_fibre (1 - nu_cross) / 2 / E_cross.
  const std::string text =
      test::small_head + parameter("specimen.material.nu_fibre", "values = [0.3, 0.9, 0.2]");
  const Outcome run = maille_command("study " + study(text) + " --out " + (folder / "out").string());
  EXPECT_EQ(run.code, 1) << "something failed";
  const auto table = read_study_table(folder / "out/study.jsonl").rows;
  ASSERT_EQ(table.size(), 9u);
  for (const StudyRow& row : table) {
    EXPECT_EQ(row.status, row.number == 2 ? Status::failed : Status::done) << row.message;
    EXPECT_EQ(row.message.find("nu_fibre") != std::string::npos, row.number == 2) << row.message;
  }
}

// Contract: `check` counts cases, names those without an answer, and forecasts memory as `bytes_needed` does.
TEST_F(StudyCommandContract, CheckForecastsCasesAndMemory) {
  const std::string file =
      study(test::small_head + parameter("specimen.material.nu_fibre", "values = [0.3, 0.9, 0.2]"));
  const auto checked = test::json_of("check " + file + " --json");
  EXPECT_EQ(checked["cases"], 3);
  EXPECT_GT(checked["bytes_at_most"], 1000);
  EXPECT_LT(checked["bytes_at_most"], 100e6);
  const std::string words = test::done("check " + file).out;
  EXPECT_TRUE(test::has(words, "3 cases by limits")) << words;
  // Truth: 60 ns an unknown of a box (docs/speed.md), a quarter more to 1e-4.
  folder.write("cube.toml", test::pulled_box_text("[9, 9, 9]", "[\"0.4 mm\", 0, 0]"));
  const std::string cube = study("scene = \"cube.toml\"\nmethods = [\"coupled\"]\nreference = \"none\"\n" +
                                 parameter("move[1].by[1]", "values = [\"0.1 mm\"]"));
  EXPECT_NEAR(test::json_of("check " + cube + " --json")["seconds"], 3000 * 6e-8 * 1.25, 1e-6);
  EXPECT_TRUE(test::has(words, "warning: case 2 has no answer")) << words;
  EXPECT_FALSE(test::has(words, "case 3 has no answer")) << words;
}

TEST_F(StudyCommandContract, WithoutResumeATableIsNotOverwritten) {
  const std::string line = "study " + study(moves) + " --out " + (folder / "out").string();
  test::done(line);
  const std::string before = test::text_of(folder / "out/study.jsonl");
  const Outcome again = test::refused(line);
  EXPECT_TRUE(test::has(again.err, "--resume"));
  EXPECT_EQ(test::text_of(folder / "out/study.jsonl"), before);
  test::done(line + " --resume");
  EXPECT_EQ(test::text_of(folder / "out/study.jsonl"), before) << "nothing was left to do, to the second";
}

TEST_F(StudyCommandContract, ResumeRepairsATornTable) {
  const fs::path table = folder / "out/study.jsonl";
  const std::string line = "study " + study(moves) + " --threads 1 --out " + (folder / "out").string();
  test::done(line);
  const auto expected = rows(table);
  const std::string whole = test::text_of(table);
  const auto kept = read_study_table(table).rows[0].total_seconds;
  // Torn in its first line, at the end of a line within a case, and in the middle.
  for (const std::size_t size : {std::size_t{10}, whole.find('\n') + 1, whole.size() / 2}) {
    fs::resize_file(table, size);
    const Outcome run = test::done(line + " --resume");
    EXPECT_EQ(rows(table), expected);
    expect_copied(table);
    if (size > 10) {
      EXPECT_TRUE(test::has(run.out, "rows were there"));
    }
    std::ofstream(table, std::ios::binary) << whole;
  }
  EXPECT_EQ(read_study_table(table).rows[0].total_seconds, kept);
}

TEST_F(StudyCommandContract, ResumeKnowsScenesOfAChangedStudy) {
  const std::string out = " --out " + (folder / "out").string();
  const auto with = [&](const std::string& values) {
    return "study " + study(test::small_head + parameter("move.0.by.0", "values = " + values)) + out;
  };
  test::done(with("[\"1 mm\", \"2 mm\"]"));
  const Outcome run = test::done(with("[\"3 mm\", \"2 mm\"]") + " --resume");
  EXPECT_TRUE(test::has(run.out, "3 rows were there"));
  EXPECT_TRUE(test::has(run.out, "3 rows of other scenes put aside"));
  EXPECT_EQ(read_study_table(folder / "out/study.jsonl").rows.size(), 6u);
  EXPECT_EQ(read_study_table(folder / "out/study_older.jsonl").rows.size(), 3u);
}

/// Starts a study, sends it a signal once its table holds a row, waits for its end. @return its exit code
int end_early(const std::string& arguments, const fs::path& table, const char* signal) {
  return test::shell(fmt::format("{0} {1} > /dev/null 2>&1 & p=$!; for i in $(seq 600); do test -s {2} && "
                                 "break; sleep 0.05; done; kill -{3} $p; wait $p; exit $?",
                                 MAILLE_COMMAND, arguments, table.string(), signal))
      .code;
}

TEST_F(StudyCommandContract, KilledAtAnyMomentItLosesTheCaseInFlightAtMost) {
  // Each case takes some tens of milliseconds, so that the signal comes among them.
  const std::string many = test::small_head + "repetitions = 40\n" +
                           parameter("move.0.by.0", "range = [\"0.1 mm\", \"0.8 mm\"]\ncount = 40");
  const std::string file = study(many);
  test::done("study " + file + " --jobs 2 --threads 1 --out " + (folder / "whole").string());
  for (const char* signal : {"KILL", "INT"}) {
    const fs::path out = folder / signal, table = out / "study.jsonl";
    const std::string line = "study " + file + " --threads 1 --out " + out.string();
    EXPECT_EQ(end_early(line, table, signal), signal[0] == 'K' ? 137 : 130);
    const auto before = read_study_table(table).rows;
    ASSERT_GT(before.size(), 0u);
    ASSERT_LT(before.size(), 120u) << "it was over before the signal came";
    const Outcome resumed = test::done(line + " --resume");
    EXPECT_EQ(rows(table), rows(folder / "whole/study.jsonl"));
    const auto after = read_study_table(table).rows;
    for (const StudyRow& row : before)
      EXPECT_TRUE(std::any_of(after.begin(), after.end(), [&](const StudyRow& other) {
        return other.hash == row.hash && other.total_seconds == row.total_seconds;
      })) << "what was there is not run again";
  }
}

TEST_F(StudyCommandContract, PartsMergedAreTheWhole) {
  const std::string file =
                        study(moves + "[[parameter]]\nkey = \"specimen.fibre.angle\"\nvalues = [\"0 deg\", "
                                      "\"30 deg\"]\n"),
                    with_files = study("vtk = [1, 16]\n" + test::text_of(file), "study");
  const std::string line = "study " + with_files + " --threads 1 --out ";
  test::done(line + (folder / "whole").string());
  for (const char* part : {"1/3", "2/3", "3/3"})
    test::done(line + (folder / "parts").string() + " --shard " + part);
  const std::string merge =
      "study merge " + (folder / "parts").string() + " --out " + (folder / "merged").string();
  const Outcome merged = test::done(merge);
  EXPECT_EQ(rows(folder / "merged/study.jsonl"), rows(folder / "whole/study.jsonl"));
  expect_copied(folder / "merged/study.jsonl");
  EXPECT_TRUE(test::has(test::text_of(folder / "merged/study.pvd"), "../parts/study_0016_fem_q1.vti"));
  const Outcome with_study = test::done(merge + " --study " + with_files);
  const auto sensitivity_in = [&](const char* place) {
    return nlohmann::json::parse(test::text_of(folder / place))["sensitivity"];
  };
  EXPECT_EQ(sensitivity_in("merged/study_about.json"), sensitivity_in("whole/study_about.json"));
  EXPECT_FALSE(sensitivity_in("merged/study_about.json").empty());
  EXPECT_TRUE(test::has(with_study.out, "Sobol indices"));
  fs::remove(folder / "parts/study_2_of_3.jsonl");
  const Outcome partly = maille_command(merge);
  EXPECT_EQ(partly.code, 1);
  EXPECT_TRUE(test::has(partly.out, "5 cases are missing"));
}

TEST_F(StudyCommandContract, SnakemakeRunsThePartsAndMergesThem) {
  if (test::shell("command -v snakemake").code != 0)
    GTEST_SKIP() << "there is no snakemake: install the package of that name";
  const std::string file = study(moves);
  test::done("study " + file + " --threads 1 --out " + (folder / "whole").string());
  const Outcome run = test::shell(fmt::format("cd {0} && snakemake --snakefile {1} --cores 2 --config "
                                              "study={2} shards=3 out={0}/flow maille={3} 2>&1",
                                              folder.path().string(), MAILLE_WORKFLOW, file, MAILLE_COMMAND));
  ASSERT_EQ(run.code, 0) << run.out;
  EXPECT_EQ(rows(folder / "flow/study.jsonl"), rows(folder / "whole/study.jsonl"));
}

TEST_F(StudyCommandContract, CasesSideBySideAreTheSameAndMarked) {
  const std::string line = "study " + study(moves) + " --threads 1 --out ";
  test::done(line + (folder / "one").string());
  test::done(line + (folder / "two").string() + " --jobs 2");
  EXPECT_EQ(rows(folder / "one/study.jsonl"), rows(folder / "two/study.jsonl"));
  for (const StudyRow& row : read_study_table(folder / "two/study.jsonl").rows)
    EXPECT_EQ(row.timing, Timing::side_by_side);
}

TEST_F(StudyCommandContract, DrawsAPlotAParameterThatVaries) {
  const std::string file = study(moves + "[[parameter]]\nkey = \"specimen.fibre.angle\"\n"
                                         "values = [\"0 deg\", \"30 deg\"]\n");
  const std::string line =
      "study " + file + " --threads 1 --out " + (folder / "out").string() + " --picture ";
  const Outcome run = test::done(line + (folder / "plots.svg").string());
  const std::string svg = test::text_of(folder / "plots.svg");
  for (const char* word : {"force [N]", "relaxed", "fem_q1", "move.0.by.0", "specimen.fibre.angle", "</svg>"})
    EXPECT_TRUE(test::has(svg, word)) << word;
  EXPECT_FALSE(test::has(svg, "limits")) << "it knows no force";
  const Outcome again = test::done(line + (folder / "plots.png").string() + " --resume");
  EXPECT_EQ(test::text_of(folder / "plots.png").substr(1, 3), "PNG");
  const Outcome errors =
      test::done(line + (folder / "errors.svg").string() + " --resume --picture-of relative_l2");
  EXPECT_FALSE(test::has(test::text_of(folder / "errors.svg"), "fem_q1")) << "the reference has no error";
  test::refused(line + (folder / "plots.gif").string() + " --resume");
}

TEST_F(StudyCommandContract, DrawsTheForceOverTwoParametersAsAMap) {
  const std::string over_two =
      "scene = \"strip.toml\"\nmethods = [\"coupled\"]\nreference = \"fem_q1\"\n" +
      test::parameter("specimen.material.E_fibre", "values = [\"20 kPa\", \"40 kPa\", \"80 kPa\"]") +
      test::parameter("specimen.fibre.angle", "values = [\"0 deg\", \"20 deg\", \"40 deg\"]");
  const std::string line = "study " + study(over_two, "two") + " --threads 1 --resume --out " +
                           (folder / "two").string() + " --picture " + (folder / "map.svg").string() +
                           " --picture-of ";
  const Outcome run = test::done(line + "force");
  const std::string svg = test::text_of(folder / "map.svg");
  for (const char* word : {"strip, coupled", "strip, fem_q1", "force [N]", "fibre.angle", "</svg>"})
    EXPECT_TRUE(test::has(svg, word)) << word;
  // Truth: in the table, a stiffer fibre along the pull takes more.
  std::map<double, double> force;
  for (const StudyRow& row : read_study_table(folder / "two/two.jsonl").rows)
    if (row.method == "coupled" && std::get<double>(row.parameters[1].second) == 0)
      force[std::get<double>(row.parameters[0].second)] = row.force.value();
  ASSERT_EQ(force.size(), 3u);
  EXPECT_GT(force[80], 1.5 * force[40]);
  EXPECT_GT(force[40], 1.5 * force[20]);
  test::refused(line + "colour");
  EXPECT_EQ(maille_command(line + "test_stiffness").code, 1) << "the strip has no [test]";
}

TEST_F(StudyCommandContract, OneValueIsNoPicture) {
  const Outcome run = maille_command(
      "study " + study(test::small_head + parameter("specimen.fibre.angle", "values = [\"0 deg\"]")) +
      " --threads 1 --out " + (folder / "out").string() + " --picture " + (folder / "plots.svg").string() +
      " --picture-of relative_l2");
  EXPECT_EQ(run.code, 1) << "what was asked for is not there: " << run.err;
  EXPECT_TRUE(test::has(run.err, "no picture: no parameter has errors at several values"));
  EXPECT_FALSE(fs::exists(folder / "plots.svg"));
}

TEST_F(StudyCommandContract, WrongUseIsExitCodeTwo) {
  const std::string file = study(moves), out = " --out " + (folder / "out").string();
  for (const char* shard : {"0/2", "3/2", "1", "a/2", "1/2x"})
    EXPECT_EQ(maille_command("study " + file + out + " --shard " + shard).code, 2) << shard;
  test::refused("study " + study("methods = 3\n", "faulty") + out);
  test::refused("study " + (folder / "none.toml").string() + out);
  EXPECT_EQ(maille_command("study merge " + folder.path().string() + out).code, 2) << "no tables";
  test::refused("study " + file + out + " --jobs 0");
}

/// Which rows of a table `maille study --resume` takes as known, and which it answers anew.

class StudyResumeContract : public testing::Test {
protected:
  void SetUp() override { folder.write("study.toml", moves); }
  Outcome run(const std::string& more = "") const {
    return maille_command("study " + (folder / "study.toml").string() + " --out " +
                          (folder / "out").string() + " " + more);
  }
  std::vector<StudyRow> rows() const { return read_study_table(table).rows; }

  const test::StudyFolder folder;
  const fs::path table = folder / "out/study.jsonl";
  const std::string moves = test::small_head + parameter("move.0.by.0", "values = [\"0.2 mm\", \"0.4 mm\"]");
};

TEST_F(StudyResumeContract, OtherThreadsAndJobsKeepEveryRow) {
  ASSERT_EQ(run("--threads 1").code, 0);
  const std::string before = test::text_of(table);
  for (const char* other : {"--resume --threads 2", "--resume --jobs 2", "--resume --jobs 2 --threads 3"}) {
    const Outcome again = run(other);
    ASSERT_EQ(again.code, 0) << again.err;
    EXPECT_TRUE(test::has(again.out, "6 rows were there"));
    EXPECT_EQ(test::text_of(table), before);
  }
  EXPECT_FALSE(fs::exists(folder / "out/study_older.jsonl"));
}

TEST_F(StudyResumeContract, DataThatAHeaderNamesCount) {
  folder.write("a.mhd", "ObjectType = Image\nNDims = 3\nDimSize = 4 2 2\nElementType = MET_UCHAR\n"
                        "ElementSpacing = 1 1 1\nElementDataFile = a.raw\n");
  folder.write("a.raw", std::string(16, '\1'));
  folder.write("image.toml", "[specimen]\nshape = \"image\"\nimage = \"a.mhd\"\nlabels = { 1 = { "
                             "youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 } }\n[[hold]]\nwhere = "
                             "\"x-\"\n[[move]]\nwhere = \"x+\"\nby = [\"0.1 mm\", 0, 0]\n");
  folder.write("study.toml", "scene = \"image.toml\"\nmethods = [\"limits\"]\nreference = \"relaxed\"\n" +
                                 parameter("move.0.by.0", "values = [\"0.1 mm\", \"0.2 mm\"]"));
  ASSERT_EQ(run().code, 0);
  EXPECT_EQ(rows().at(0).cells, 16);
  std::string other(16, '\1');
  other[5] = '\0'; // segmented again: the header is as it was
  folder.write("a.raw", other);
  const Outcome again = run("--resume");
  ASSERT_EQ(again.code, 0) << again.err;
  EXPECT_FALSE(test::has(again.out, "rows were there"));
  for (const StudyRow& row : rows())
    EXPECT_EQ(row.cells, 15);
}

TEST_F(StudyResumeContract, FailuresOfTheMachineAreTriedAgainAndOthersAreNot) {
  ASSERT_EQ(run().code, 0);
  std::vector<StudyRow> some = rows();
  const auto fail = [&](std::size_t i, const char* message, bool is_of_machine, Status status) {
    some[i].status = status;
    some[i].message = message;
    some[i].is_of_machine = is_of_machine;
  };
  fail(0, "its process was ended by signal 9 (Killed)", true, Status::failed);
  fail(1, "relaxed needs about 2 GiB, 1 GiB are available", false, Status::refused);
  fail(3, "the energy is not positive", false, Status::failed);
  write_study_table(some, folder / "out/study");
  EXPECT_EQ(rows().at(0).is_of_machine, true) << "it is read back";
  const Outcome again = run("--resume");
  EXPECT_EQ(again.code, 1) << "one row failed for good";
  EXPECT_TRUE(test::has(again.out, "4 rows were there"));
  const auto after = rows();
  ASSERT_EQ(after.size(), 6u);
  for (std::size_t i = 0; i < after.size(); ++i)
    EXPECT_EQ(after[i].status, i == 3 ? Status::failed : Status::done) << i;
  EXPECT_EQ(after[4].total_seconds, some[4].total_seconds) << "what was there is not run again";
  EXPECT_FALSE(fs::exists(folder / "out/study_older.jsonl")) << "a failure of the machine is worth nothing";
}

TEST_F(StudyResumeContract, AFileThatCannotBeWrittenDoesNotCostTheRow) {
  folder.write("study.toml", "vtk = \"all\"\n" + moves);
  fs::create_directories(folder / "out/study_0001_relaxed.vti"); // a folder is in its place
  const Outcome first = run();
  EXPECT_EQ(first.code, 1);
  EXPECT_TRUE(test::has(first.out, "no file for ParaView"));
  const auto before = rows();
  ASSERT_EQ(before.size(), 6u);
  for (const StudyRow& row : before)
    EXPECT_EQ(row.status, Status::done) << row.message;
  EXPECT_TRUE(before[1].error && before[1].vtk.empty());
  EXPECT_EQ(before[0].vtk, "study_0001_limits.vti");
  fs::remove(folder / "out/study_0001_relaxed.vti");
  const Outcome again = run("--resume");
  EXPECT_EQ(again.code, 0) << again.out;
  EXPECT_TRUE(test::has(again.out, "5 rows were there"));
  EXPECT_EQ(rows().at(1).vtk, "study_0001_relaxed.vti");
}

// A row of numbers that JSON does not have is a row all the same.
TEST(StudyRowContract, ParametersThatAreNoNumbersReadBack) {
  StudyRow row;
  row.study = "s";
  row.method = "limits";
  row.parameters = {{"E", std::nan("")}, {"nu", 0.3}};
  const StudyRow back = parse_study_table(json_line(row) + "\n", "t.jsonl").rows.at(0);
  ASSERT_EQ(back.parameters.size(), 2u);
  EXPECT_TRUE(std::isinf(std::get<double>(back.parameters[0].second)));
  EXPECT_EQ(std::get<double>(back.parameters[1].second), 0.3);
}

} // namespace
} // namespace maille::studies
