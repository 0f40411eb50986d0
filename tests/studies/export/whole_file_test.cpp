#include "maille/studies/export/whole_file.hpp"

#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <future>
#include <random>
#include <string>
#include <sys/stat.h>
#include <vector>

namespace maille::studies {
namespace {

namespace fs = std::filesystem;

TEST(WholeFileContract, ReplacesWhatALinkLeadsToAndKeepsTheLink) {
  const test::TemporaryFolder folder;
  folder.write("target", "old");
  fs::create_symlink("target", folder / "link");
  write_whole(folder / "link", "new");
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(test::text_of(folder / "target"), "new");
}

TEST(WholeFileContract, WritesIntoAPipeInsteadOfReplacingIt) {
  const test::TemporaryFolder folder;
  const fs::path pipe = folder / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  auto reader = std::async(std::launch::async, [&] { return test::text_of(pipe); });
  write_whole(pipe, "through the pipe");
  EXPECT_EQ(reader.get(), "through the pipe");
  EXPECT_TRUE(fs::is_fifo(pipe));
}

TEST(WholeFileContract, RefusesWritersOfFilesWhereAPipeStands) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_THROW(write_whole(folder / "pipe", [](const fs::path&) {}), fs::filesystem_error);
  EXPECT_TRUE(fs::is_fifo(folder / "pipe"));
}

TEST(WholeFileContract, EndsAtLinksThatLeadToThemselves) {
  const test::TemporaryFolder folder;
  fs::create_symlink("loop", folder / "loop");
  EXPECT_THROW(write_whole(folder / "loop", "text"), fs::filesystem_error);
}

TEST(WholeFileContract, PiecesOfOthersInAGuardedFolderStay) {
  const test::TemporaryFolder folder;
  fs::create_directories(folder / "out/box_limits");
  const FolderLock lock(folder / "out", "box", FolderLock::Sharing::none);
  const fs::path mine = folder.write("out/box_limits/0000.vtu", "mine");
  EXPECT_THROW(write_whole(mine, "new"), FolderTaken);
  EXPECT_EQ(test::text_of(mine), "mine");
  write_whole(folder / "out/box_limits/0001.vtu", "new");
  write_whole(folder / "out/box_limits/0001.vtu", "newer"); // its own
}

TEST(WholeFileContract, AFileThatSpeaksOfMailleIsNotOfMaille) {
  const test::TemporaryFolder folder;
  std::mt19937 dice(41);
  const std::vector<std::string> words{"maille",    "\"maille\": \"1\"", "# maille\n", "Comment = maille\n",
                                       "<VTKFile ", "Name=\"Units\" ",   "NRRD0005\n", "ply\n",
                                       "{\n",       "study,case",        "<svg></svg>"};
  for (const std::string ending : {"vti", "pvd", "csv", "json", "jsonl", "nii", "nii.gz", "nrrd", "mha",
                                   "stl", "ply", "html", "png", "svg", "mp4"})
    for (int i = 0; i < 20; ++i) {
      std::string text = "of ";
      for (int n = 0; n < 40; ++n)
        text += words[dice() % words.size()] + std::string(dice() % 9, ' ');
      EXPECT_FALSE(is_own_result(folder.write("box_limits." + ending, text + "."))) << ending << text;
    }
}

} // namespace
} // namespace maille::studies
