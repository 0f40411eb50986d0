/// Files that are there when they are looked at and gone, shorter or unreadable a moment later.

#include "writing_commands.hpp"

namespace maille {
namespace {

using test::CommandFolder;
using test::Files;
using test::files_in;
using test::Outcome;

class VanishingContract : public testing::Test {
protected:
  VanishingContract() {
    const std::string header = "NDims = 3\nDimSize = 16 16 16\nElementSpacing = 1 1 1\nElementType = "
                               "MET_UCHAR\nElementDataFile = LOCAL\n";
    folder.folder().write("in/labels.mha", header + std::string(16 * 16 * 16, '\1'));
    const std::string scene =
        "[specimen]\nshape = \"image\"\nimage = \"labels.mha\"\nmaterial = \"soft.toml\"\n"
        "[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = \"x+\"\nby = [\"1 mm\", 0, 0]\n";
    folder.folder().write("in/soft.toml", "youngs_modulus = \"10 kPa\"\npoisson_ratio = 0.3\n");
    folder.folder().write("in/image.toml", scene);
    folder.folder().write("in/image_study.toml",
                          "scene = \"image.toml\"\nmethods = [\"limits\"]\nreference = \"none\"\n"
                          "[[parameter]]\nkey = \"move.0.by.0\"\nvalues = [\"0.1 mm\", \"0.2 mm\"]\n");
  }
  /// Every command that reads scenes, by one call after the other.
  void expect_a_fault(const std::string& arguments, const std::string& file, const std::string& call,
                      const std::string& what, const std::string& word) {
    ASSERT_EQ(folder.run(arguments).code, 0);
    const Files earlier = files_in(folder.out());
    ASSERT_EQ(folder.run_with_fault(arguments, call + ":0:NONE", folder.in() / file).code, 0);
    const long n = folder.n_calls(call);
    ASSERT_GT(n, 0);
    for (const long at : test::some_of(n)) {
      const Outcome run =
          folder.run_with_fault(arguments, fmt::format("{}:{}:{}", call, at, what), folder.in() / file);
      const std::string when = fmt::format("{} {} of {}: {}", call, at, n, run.err);
      // The end of a file may be met where it is.
      EXPECT_TRUE(run.code == 2 || run.code == 1 || (what == "END" && run.code == 0)) << when << run.code;
      if (run.code == 2) {
        EXPECT_NE(run.err.find(file), std::string::npos) << when;
        EXPECT_NE(run.err.find(word), std::string::npos) << when;
      }
      for (const auto& [name, text] : files_in(folder.out()))
        EXPECT_TRUE(test::is_whole(name, text, text)) << when << name;
      for (const auto& [name, text] : earlier)
        EXPECT_TRUE(std::filesystem::exists(folder.out() / name)) << when << name;
    }
  }
  const CommandFolder folder;
};

TEST_F(VanishingContract, AnImageThatIsGoneIsAFault) {
  expect_a_fault("run IN/image.toml --out OUT", "labels.mha", "open_to_read", "ENOENT", "expected");
}
TEST_F(VanishingContract, AnImageThatCannotBeReadOnIsAFault) {
  expect_a_fault("run IN/image.toml --out OUT", "labels.mha", "read", "EIO", "expected");
}
TEST_F(VanishingContract, AnImageThatHasBecomeShorterIsAFault) {
  expect_a_fault("run IN/image.toml --out OUT", "labels.mha", "read", "END", "expected");
}
TEST_F(VanishingContract, AStudyWhoseImageGoesKeepsItsRows) {
  expect_a_fault("study IN/image_study.toml --threads 1 --resume --out OUT", "labels.mha", "open_to_read",
                 "ENOENT", "expected");
}
// Part of a scene is a scene without its conditions: it must not be taken for the whole.
TEST_F(VanishingContract, ASceneThatCannotBeReadOnIsAFault) {
  for (const int at : {1, 2}) { // the text, and its end
    const Outcome run = folder.run_with_fault("run IN/image.toml --out OUT", fmt::format("read:{}:EIO", at),
                                              folder.in() / "image.toml");
    EXPECT_EQ(run.code, 2) << at;
    EXPECT_NE(run.err.find("image.toml: expected a scene file that can be read"), std::string::npos)
        << run.err;
    EXPECT_TRUE(files_in(folder.out()).empty());
  }
}
TEST_F(VanishingContract, AMaterialThatIsGoneIsAFault) {
  expect_a_fault("run IN/image.toml --out OUT", "soft.toml", "open_to_read", "ENOENT", "expected");
}

// Between two cases, in earnest.
TEST_F(VanishingContract, CasesWithoutTheirImageAreFailedRows) {
  const std::string study = "study IN/image_study.toml --threads 1 --out OUT";
  const Outcome run = folder.run_with_fault(study, "open_to_read:0:NONE", folder.in() / "labels.mha");
  ASSERT_EQ(run.code, 0);
  const long n =
      folder.n_calls("open_to_read"); // of the process that reads the study; cases are other processes'
  std::filesystem::remove_all(folder.out());
  const Outcome gone =
      folder.run_with_fault(study, fmt::format("open_to_read:{}:ENOENT", n + 1), folder.in() / "labels.mha");
  EXPECT_EQ(gone.code, 1) << gone.err;
  EXPECT_NE(gone.out.find("failed"), std::string::npos) << gone.out;
}

// MPI, which AMG starts, ends the process where it cannot write its files.
TEST(TemporaryFolderContract, AMissingOneTakesNoAnswerAway) {
  const CommandFolder folder;
  const Outcome run = folder.run(
      "compare IN/box.toml --methods limits,fem_q1 --fem-solver amg --json OUT/r.json", "TMPDIR=/proc");
  EXPECT_EQ(run.code, 0) << run.err;
  const auto results = nlohmann::json::parse(test::text_of(folder.out() / "r.json"))["results"];
  ASSERT_EQ(results.size(), 2u);
  for (const auto& row : results)
    EXPECT_EQ(row["status"], "done") << row;
}

} // namespace
} // namespace maille
