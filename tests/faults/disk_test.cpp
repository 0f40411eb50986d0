/// Disks that are full, fail or are read-only, and programs that are killed in a write. Whatever happens,
/// files appear whole or not at all, and what was there stays until it is replaced.

#include "writing_commands.hpp"

#include <unistd.h>

namespace maille {
namespace {

using test::CommandFolder;
using test::Files;
using test::files_in;
using test::Outcome;
using test::WritingCommand;

class DiskContract : public testing::TestWithParam<WritingCommand> {
protected:
  void SetUp() override {
    folder.prepare(GetParam());
    const Outcome first = folder.run(GetParam().arguments);
    if (first.err.find("no picture") != std::string::npos)
      GTEST_SKIP() << first.err;
    ASSERT_EQ(first.code, GetParam().exit_code) << first.err;
    earlier = files_in(folder.out());
    ASSERT_FALSE(earlier.empty());
    // Counts the calls; by the way, the command goes over its own files.
    const Outcome again = fail_at("write", 0, "NONE");
    ASSERT_EQ(again.code, GetParam().exit_code) << again.err;
    for (const char* call : {"write", "open", "rename"}) {
      n_calls[call] = folder.n_calls(call);
      ASSERT_GT(n_calls[call], 0) << call;
    }
  }

  Outcome fail_at(const std::string& call, long number, const std::string& what) const {
    return folder.run_with_fault(GetParam().arguments, fmt::format("{}:{}:{}", call, number, what),
                                 folder.out());
  }

  /// @param may_be_torn tables that grow line by line may end in half a line, which --resume takes off
  void expect_whole_files(const std::string& when, bool may_be_torn = false) const {
    const Files now = files_in(folder.out());
    for (const auto& [name, text] : earlier)
      EXPECT_TRUE(now.contains(name)) << when << ": " << name << " is lost";
    for (const auto& [name, text] : now) {
      const bool is_table = name == "study.jsonl" || name == "study.csv";
      if (may_be_torn && is_table)
        continue;
      const auto example = earlier.find(name);
      EXPECT_TRUE(test::is_whole(name, text, example == earlier.end() ? text : example->second))
          << when << ": " << name << " is not whole: " << text.size() << " bytes";
    }
  }

  void fill_the_disk() const;
  void kill_it() const;

  const CommandFolder folder;
  Files earlier;
  std::map<std::string, long> n_calls;
};

void DiskContract::fill_the_disk() const {
  for (const auto& [call, n] : n_calls)
    for (const long at : call == "write" ? test::some_of(n) : std::set<long>{n}) {
      const std::string when = fmt::format("no space at {} {} of {}", call, at, n);
      const Outcome run = fail_at(call, at, "ENOSPC");
      // A picture is optional: without it the comparison stands, and stderr says why it is missing.
      EXPECT_TRUE(run.code == 1 || run.code == 2 || (run.code == 0 && !run.err.empty()))
          << when << ": exit code " << run.code;
      EXPECT_FALSE(run.err.empty()) << when;
      expect_whole_files(when);
      for (const auto& [name, text] : files_in(folder.out(), true))
        ADD_FAILURE() << when << ": " << name << " is left over";
    }
}

void DiskContract::kill_it() const {
  for (const auto& [call, at] :
       {std::pair{"write", n_calls.at("write") / 2 + 1}, std::pair{"write", n_calls.at("write")},
        std::pair{"rename", n_calls.at("rename")}}) {
    const std::string when = fmt::format("killed in {} {} of {}", call, at, n_calls.at(call));
    const Outcome killed = fail_at(call, std::min(at, n_calls.at(call)), "KILL");
    // 1: the call was gnuplot's, and the command says that its picture failed.
    EXPECT_TRUE(killed.code == 128 + 9 ||
                (killed.code == 1 && killed.err.find("gnuplot") != std::string::npos))
        << when << killed.code << killed.err;
    expect_whole_files(when, true);
  }
}

// One test a command: all of it begins with a run in which nothing fails.
TEST_P(DiskContract, FilesAreWholeOrNotThereAndEarlierOnesStay) {
  const Files before = files_in(folder.out());
  const Outcome read_only = fail_at("open", 1, "EROFS");
  EXPECT_TRUE(read_only.code == 1 || read_only.code == 2 || GetParam().name == "picture") << read_only.code;
  EXPECT_FALSE(read_only.err.empty());
  EXPECT_EQ(files_in(folder.out()), before) << "a read-only folder";

  const Outcome little_by_little = fail_at("write", 1, "SHORT");
  EXPECT_EQ(little_by_little.code, GetParam().exit_code) << little_by_little.err;
  expect_whole_files("writes that do half of what they are asked for");

  fill_the_disk();

  const Outcome interrupted = fail_at("write", n_calls.at("write") / 2 + 1, "INT");
  EXPECT_TRUE(interrupted.code == 0 || interrupted.code == 1 || interrupted.code == 128 + 2)
      << interrupted.code << interrupted.err;
  expect_whole_files("interrupted in a write", true);

  kill_it();

  const Outcome after = folder.run(GetParam().arguments);
  EXPECT_EQ(after.code, GetParam().exit_code) << after.err;
  expect_whole_files("afterwards");
}

INSTANTIATE_TEST_SUITE_P(Commands, DiskContract, testing::ValuesIn(test::writing_commands()),
                         [](const auto& one) { return one.param.name; });

// The kernel's own full disk: every write fails.
TEST(FullDeviceContract, OutputThatCannotBeWrittenIsAFailure) {
  const CommandFolder folder;
  for (const std::string arguments :
       {"--version", "materials", "explain IN/box.toml",
        "compare IN/box.toml --methods limits --reference limits --json -", "run IN/box.toml --out OUT",
        "export IN/box.toml", "report IN/results --out OUT/page.html"}) {
    if (arguments.starts_with("report")) {
      ASSERT_EQ(folder.run("compare IN/box.toml --methods limits --reference limits --out IN/results").code,
                0);
    }
    const Outcome run = folder.run(arguments + " >/dev/full");
    EXPECT_EQ(run.code, 1) << arguments;
    EXPECT_NE(run.err.find("cannot write to "), std::string::npos) << arguments << ": " << run.err;
  }
  for (const std::string arguments :
       {"materials --json /dev/full", "run IN/box.toml --json /dev/full",
        "compare IN/box.toml --methods limits --reference limits --csv /dev/full",
        "export IN/box.toml --out /dev/full"}) {
    const Outcome run = folder.run(arguments);
    EXPECT_EQ(run.code, 1) << arguments;
    EXPECT_NE(run.err.find("No space left"), std::string::npos) << arguments << ": " << run.err;
  }
}

TEST(FullDeviceContract, OutputThatNobodyTakesIsAFailure) {
  const CommandFolder folder;
  EXPECT_EQ(folder.run("materials >&-").code, 1);
  EXPECT_EQ(folder.run("run IN/box.toml >&-").code, 1);
}

// A file system of 100 KiB, where one may mount such.
TEST(FullDeviceContract, ASmallFileSystemFillsUp) {
  const CommandFolder folder;
  const std::string out = folder.out().string();
  if (test::shell("unshare -rm true").code != 0)
    GTEST_SKIP() << "no file systems of one's own here";
  folder.folder().write("in/large.toml", CommandFolder::box("[\"0.6 mm\", 0, 0]", "[40, 40, 40]"));
  const Outcome run = test::shell(fmt::format("unshare -rm sh -c 'mount -t tmpfs -o size=100k tmpfs {0} || "
                                              "exit 99; echo earlier >{0}/earlier; {1} run {2} "
                                              "--methods limits --out {0}; echo code $?; ls -A {0}'",
                                              out, MAILLE_COMMAND, (folder.in() / "large.toml").string()));
  if (run.code == 99)
    GTEST_SKIP() << "no tmpfs may be mounted here";
  EXPECT_NE(run.out.find("code 1\nearlier\n"), std::string::npos) << run.out;
  EXPECT_NE(run.err.find("large_limits"), std::string::npos) << "names the file: " << run.err;
}

TEST(FullDeviceContract, AReadOnlyFileSystemIsFoundBeforeTheWork) {
  const CommandFolder folder;
  for (const std::string arguments :
       {"run IN/box.toml --out /proc/maille", "study IN/study.toml --out /proc/maille",
        "trade IN/box.toml --out /proc/maille"}) {
    const Outcome run = folder.run(arguments);
    EXPECT_EQ(run.code, 2) << arguments;
    EXPECT_NE(run.err.find("--out /proc/maille: expected a folder that can be written"), std::string::npos)
        << run.err;
    EXPECT_TRUE(run.out.empty()) << run.out;
  }
}

} // namespace
} // namespace maille
