/// Which rows of a table `maille study --resume` takes as known, and which it answers anew.

#include "studies/commands/run_command.hpp"
#include "studies/study/study_scenes.hpp"
#include "study/plan/study_table.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace maille::studies {
namespace {

namespace fs = std::filesystem;
using test::maille_command;
using test::Outcome;
using test::parameter;

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
    EXPECT_NE(again.out.find("6 rows were there"), std::string::npos) << again.out;
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
  EXPECT_EQ(again.out.find("rows were there"), std::string::npos) << again.out;
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
  EXPECT_NE(again.out.find("4 rows were there"), std::string::npos) << again.out;
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
  EXPECT_NE(first.out.find("no file for ParaView"), std::string::npos) << first.out;
  const auto before = rows();
  ASSERT_EQ(before.size(), 6u);
  for (const StudyRow& row : before)
    EXPECT_EQ(row.status, Status::done) << row.message;
  EXPECT_TRUE(before[1].error && before[1].vtk.empty());
  EXPECT_EQ(before[0].vtk, "study_0001_limits.vti");
  fs::remove(folder / "out/study_0001_relaxed.vti");
  const Outcome again = run("--resume");
  EXPECT_EQ(again.code, 0) << again.out;
  EXPECT_NE(again.out.find("5 rows were there"), std::string::npos) << again.out;
  EXPECT_EQ(rows().at(1).vtk, "study_0001_relaxed.vti");
}

// A row of numbers that JSON does not have is a row all the same.
TEST(StudyRowContract, ParametersThatAreNoNumbersReadBack) {
  StudyRow row;
  row.study = "s";
  row.method = "limits";
  row.parameters = {{"E", std::nan("")}, {"nu", 0.3}};
  const StudyRow back = row_from_json(json_line(row));
  ASSERT_EQ(back.parameters.size(), 2u);
  EXPECT_TRUE(std::isinf(std::get<double>(back.parameters[0].second)));
  EXPECT_EQ(std::get<double>(back.parameters[1].second), 0.3);
}

} // namespace
} // namespace maille::studies
