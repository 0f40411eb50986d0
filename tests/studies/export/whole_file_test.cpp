#include "export/whole_file.hpp"

#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <future>
#include <sys/stat.h>

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

} // namespace
} // namespace maille::studies
