/// Disks that are full, fail or are read-only, and programs that are killed in a write. Whatever happens,
/// files appear whole or not at all, and what was there stays until it is replaced.

#include "support/kit.hpp"
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
    EXPECT_EQ(killed.code, 128 + 9) << when << killed.err;
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
  EXPECT_EQ(interrupted.code, 128 + 2) << interrupted.err;
  expect_whole_files("interrupted in a write", true);

  kill_it();

  const Outcome after = folder.run(GetParam().arguments);
  EXPECT_EQ(after.code, GetParam().exit_code) << after.err;
  expect_whole_files("afterwards");
}

INSTANTIATE_TEST_SUITE_P(Commands, DiskContract, testing::ValuesIn(test::writing_commands()),
                         [](const auto& one) { return one.param.name; });

// The kernel's own full disk: every write fails.
TEST(FullDeviceContract, FullOutputIsAFailure) {
  const CommandFolder folder;
  for (const std::string arguments :
       {"--version", "check library", "check --why IN/box.toml",
        "compare IN/box.toml --methods limits --reference limits --json -", "run IN/box.toml --out OUT",
        "run IN/box.toml --write -", "report IN/results --out OUT/page.html"}) {
    if (arguments.starts_with("report")) {
      ASSERT_EQ(folder.run("compare IN/box.toml --methods limits --reference limits --out IN/results").code,
                0);
    }
    const Outcome run = folder.run(arguments + " >/dev/full");
    EXPECT_EQ(run.code, 1) << arguments;
    EXPECT_TRUE(test::has(run.err, "cannot write to ")) << arguments << ": ";
  }
  for (const std::string arguments :
       {"check library --json /dev/full", "run IN/box.toml --json /dev/full",
        "compare IN/box.toml --methods limits --reference limits --csv /dev/full",
        "run IN/box.toml --write /dev/full"}) {
    const Outcome run = folder.run(arguments);
    EXPECT_EQ(run.code, 1) << arguments;
    EXPECT_TRUE(test::has(run.err, "No space left")) << arguments << ": ";
  }
}

TEST(FullDeviceContract, ClosedOutputIsAFailure) {
  const CommandFolder folder;
  EXPECT_EQ(folder.run("check library >&-").code, 1);
  EXPECT_EQ(folder.run("run IN/box.toml >&-").code, 1);
}

// A file system of 100 KiB, where one may mount such.
TEST(FullDeviceContract, ASmallFileSystemFillsUp) {
  const CommandFolder folder;
  const std::string out = folder.out().string();
  if (test::shell("unshare -rm true").code != 0)
    GTEST_SKIP() << "no file systems of one's own here";
  folder.write("in/large.toml", CommandFolder::box("[\"0.6 mm\", 0, 0]", "[40, 40, 40]"));
  const Outcome run = test::shell(fmt::format("unshare -rm sh -c 'mount -t tmpfs -o size=100k tmpfs {0} || "
                                              "exit 99; echo earlier >{0}/earlier; {1} run {2} "
                                              "--methods limits --out {0}; echo code $?; ls -A {0}'",
                                              out, MAILLE_COMMAND, (folder.in() / "large.toml").string()));
  if (run.code == 99)
    GTEST_SKIP() << "no tmpfs may be mounted here";
  EXPECT_TRUE(test::has(run.out, "code 1\nearlier\n"));
  EXPECT_TRUE(test::has(run.err, "large_limits")) << "names the file: ";
}

TEST(FullDeviceContract, AReadOnlyFileSystemIsFoundBeforeTheWork) {
  const CommandFolder folder;
  for (const std::string arguments :
       {"run IN/box.toml --out /proc/maille", "study IN/study.toml --out /proc/maille",
        "study trade IN/box.toml --out /proc/maille"}) {
    const Outcome run = folder.run(arguments);
    EXPECT_EQ(run.code, 2) << arguments;
    EXPECT_TRUE(test::has(run.err, "--out /proc/maille: expected a folder that can be written"));
    EXPECT_TRUE(run.out.empty()) << run.out;
  }
}

/// Files that are there when they are looked at and gone, shorter or unreadable a moment later.

class VanishingContract : public testing::Test {
protected:
  VanishingContract() {
    folder.write("in/labels.mha", test::meta_image({16, 16, 16}, std::string(16 * 16 * 16, '\1')));
    folder.write("in/soft.toml", "youngs_modulus = \"10 kPa\"\npoisson_ratio = 0.3\n");
    folder.write("in/image.toml",
                 "[specimen]\nshape = \"image\"\nimage = \"labels.mha\"\nmaterial = \"soft.toml\"\n" +
                     test::hold_text() + test::move_text("[\"1 mm\", 0, 0]"));
    folder.write("in/image_study.toml",
                 "scene = \"image.toml\"\nmethods = [\"limits\"]\nreference = \"none\"\n"
                 "[[parameter]]\nkey = \"move.0.by.0\"\nvalues = [\"0.1 mm\", \"0.2 mm\"]\n");
  }
  /// Every command that reads scenes, by one call after the other.
  void expect_a_fault(const std::string& arguments, const std::string& file, const std::string& call,
                      const std::string& what) {
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
        EXPECT_TRUE(test::has(run.err, file)) << when;
        EXPECT_TRUE(test::has(run.err, "expected")) << when;
      }
      for (const auto& [name, text] : files_in(folder.out()))
        EXPECT_TRUE(test::is_whole(name, text, text)) << when << name;
      for (const auto& [name, text] : earlier)
        EXPECT_TRUE(std::filesystem::exists(folder.out() / name)) << when << name;
    }
  }
  const CommandFolder folder;
};

TEST_F(VanishingContract, AFileThatGoesOrIsCutIsAFault) {
  for (const auto& [file, call, what] : {std::tuple{"labels.mha", "open_to_read", "ENOENT"},
                                         {"labels.mha", "read", "EIO"},
                                         {"labels.mha", "read", "END"},
                                         {"soft.toml", "open_to_read", "ENOENT"}})
    expect_a_fault("run IN/image.toml --out OUT", file, call, what);
}

TEST_F(VanishingContract, AStudyWhoseImageGoesKeepsItsRows) {
  expect_a_fault("study IN/image_study.toml --threads 1 --resume --out OUT", "labels.mha", "open_to_read",
                 "ENOENT");
}

// Part of a scene is a scene without its conditions: it must not be taken for the whole.
TEST_F(VanishingContract, ASceneThatCannotBeReadOnIsAFault) {
  for (const int at : {1, 2}) { // the text, and its end
    const Outcome run = folder.run_with_fault("run IN/image.toml --out OUT", fmt::format("read:{}:EIO", at),
                                              folder.in() / "image.toml");
    EXPECT_EQ(run.code, 2) << at;
    EXPECT_TRUE(test::has(run.err, "image.toml: expected a scene file that can be read"));
    EXPECT_TRUE(files_in(folder.out()).empty());
  }
}

// Between two cases, in earnest.
TEST_F(VanishingContract, CasesWithoutTheirImageAreFailedRows) {
  const std::string study = "study IN/image_study.toml --threads 1 --out OUT";
  const Outcome run = folder.run_with_fault(study, "open_to_read:0:NONE", folder.in() / "labels.mha");
  ASSERT_EQ(run.code, 0);
  const long n = folder.n_calls("open_to_read"); // of the process that reads the study, not of its cases
  std::filesystem::remove_all(folder.out());
  const Outcome gone =
      folder.run_with_fault(study, fmt::format("open_to_read:{}:ENOENT", n + 1), folder.in() / "labels.mha");
  EXPECT_EQ(gone.code, 1) << gone.err;
  EXPECT_TRUE(test::has(gone.out, "failed"));
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

/// Less memory, stack or open files than are needed (`ulimit`): a message and an exit code, never a crash or
/// an endless loop, and earlier results stay.

class MemoryContract : public testing::TestWithParam<WritingCommand> {};

TEST_P(MemoryContract, AProcessWithoutMemorySaysSo) {
#ifdef MAILLE_CHECKS_ACCESS
  GTEST_SKIP() << "the sanitizer reserves more address space than any limit leaves";
#endif
  const CommandFolder folder;
  folder.write("in/large.toml", CommandFolder::box("[\"1 mm\", 0, 0]", "[40, 40, 40]"));
  folder.write("in/large_study.toml",
               "scene = \"large.toml\"\nmethods = [\"relaxed\"]\nreference = \"none\"\n");
  folder.write("out/earlier.json", "{}");
  int n_not_started = 0, n_refused = 0, n_done = 0;
  constexpr int not_loaded = 127; // by the system's loader
  for (const int mebibytes : {4, 50, 400, 540, 700, 850, 1000, 4000}) {
    const std::string limit = fmt::format("sh -c 'ulimit -v {}; exec \"$@\"' sh", 1024 * mebibytes);
    // Where libraries are just loaded they may end the process before main (docs/robustness.md).
    if (const int bare = folder.run("--version", limit).code; bare != 0 && bare != not_loaded) {
      ++n_not_started;
      continue;
    }
    const Outcome run = folder.run(GetParam().arguments, limit);
    const bool was_loaded = run.code != not_loaded;
    EXPECT_LT(run.code, 128) << mebibytes << " MiB: signal " << run.code - 128 << '\n' << run.err;
    EXPECT_TRUE(run.code == 0 || !was_loaded || run.code == 1 || run.code == 2)
        << mebibytes << " MiB: " << run.code;
    EXPECT_TRUE(run.code == 0 || !run.err.empty() || run.out.find("failed") != std::string::npos ||
                run.out.find("refused") != std::string::npos)
        << mebibytes << " MiB: no word of why";
    for (const auto& [name, text] : files_in(folder.out()))
      EXPECT_TRUE(test::is_whole(name, text, text)) << mebibytes << " MiB: " << name;
    EXPECT_EQ(test::text_of(folder.out() / "earlier.json"), "{}");
    n_refused += run.code != 0;
    n_done += run.code == 0;
  }
  EXPECT_GT(n_not_started + n_refused, 0) << "no limit was low enough to test anything";
  EXPECT_GT(n_done, 0) << "no limit was high enough";
}

INSTANTIATE_TEST_SUITE_P(
    Commands, MemoryContract,
    testing::Values(WritingCommand{"limits", "run IN/large.toml --methods limits --out OUT"},
                    WritingCommand{"relaxed", "run IN/large.toml --methods relaxed --threads 8 --out OUT"},
                    WritingCommand{"coupled", "run IN/large.toml --methods coupled --threads 2 --out OUT"},
                    WritingCommand{"fem_q1", "run IN/box.toml --methods fem_q1 --out OUT"},
                    WritingCommand{"picture", "compare IN/box.toml --methods limits --reference limits "
                                              "--picture OUT/c.png"},
                    WritingCommand{"study", "study IN/large_study.toml --resume --threads 2 --out OUT"},
                    WritingCommand{"tissues", "check library --json OUT/m.json"}),
    [](const auto& one) { return one.param.name; });

// OpenBLAS asks for its buffer without end where the factor has taken the last of the address space.
TEST(BlasMemoryContract, AFactorThatTakesAllThereIsEnds) {
#ifdef MAILLE_CHECKS_ACCESS
  GTEST_SKIP() << "the sanitizer reserves more address space than any limit leaves";
#endif
  const CommandFolder folder;
  folder.write("in/belly.toml", CommandFolder::box("[\"1 mm\", 0, 0]", "[21, 21, 21]"));
  int n_done = 0;
  for (const int mebibytes : {740, 780, 820, 860, 900, 2000}) {
    const Outcome run =
        folder.run("run IN/belly.toml --methods fem_q1 --fem-solver cholmod --threads 1",
                   fmt::format("timeout -k 1 40 sh -c 'ulimit -v {}; exec \"$@\"' sh", 1024 * mebibytes));
    EXPECT_LT(run.code, 2) << mebibytes << " MiB: 124 is an endless loop\n" << run.err;
    EXPECT_TRUE(run.code == 0 || run.out.find("memory") != std::string::npos ||
                run.err.find("memory") != std::string::npos)
        << mebibytes << " MiB: " << run.out << run.err;
    n_done += run.code == 0;
  }
  EXPECT_GT(n_done, 0) << "no limit was high enough";
}

// An interrupted copy: the system would end the process at the first page that is not there.
TEST(PluginContract, OneThatIsCutShortIsRefused) {
  const CommandFolder folder;
  const auto plugins = std::filesystem::path(MAILLE_COMMAND).parent_path() / "plugins";
  for (const auto& [name, arguments] : {std::pair("maille-fem.so", "run IN/box.toml --methods fem_q1"),
                                        {"maille-vtk.so", "run IN/box.toml --out out"}}) {
    const std::string whole = test::text_of(plugins / name);
    for (const std::size_t left : {std::size_t{0}, std::size_t{64}, whole.size() / 2, whole.size() - 1}) {
      folder.write(name, whole.substr(0, left));
      const Outcome run = folder.run(arguments, "env LD_LIBRARY_PATH=" + folder.path().string());
      EXPECT_EQ(run.code, 1) << name << " of " << left << " bytes";
      EXPECT_TRUE(test::has(run.err, "is cut short: install it again")) << left;
    }
  }
}

// Every command that writes, and the two kinds of finite elements, under a ladder of each limit.
TEST(ResourceLimitsContract, NoCommandHangsOrEndsByASignal) {
#ifdef MAILLE_CHECKS_ACCESS
  GTEST_SKIP() << "the sanitizer reserves more address space than any limit leaves";
#endif
  const CommandFolder folder;
  folder.write("in/belly.toml", CommandFolder::box("[\"1 mm\", 0, 0]", "[32, 8, 8]"));
  std::vector<WritingCommand> commands = test::writing_commands();
  for (const char* method : {"fem_q1", "fem_q2"})
    commands.push_back({method, fmt::format("run IN/belly.toml --methods {}", method)});
  commands.push_back({"check", "check IN/box.toml"});
  commands.push_back({"explain", "check --why IN/box.toml"});
  commands.push_back({"render", "render IN/box.toml --width 40 --height 40 --out OUT/r.png"});
  folder.write("in/world.toml", test::world_text("[12, 8]") + test::object_text("a box", "rigid", "[2, 2]"));
  folder.write("in/path.toml",
               "frame_time = \"100 ms\"\n[[drive]]\nobject = \"a box\"\nby = [\"3 mm\", 0]\n");
  folder.write("in/events.csv", "time [s],event,x,y,button,name,value\n0,shot,,,,,a.png\n0,close,,,,,\n");
  for (const char* more :
       {"play IN/world.toml IN/path.toml --out OUT --picture OUT/p.png",
        "live IN/world.toml --headless --script IN/events.csv --shots OUT", "new strip --out OUT/strip.toml",
        "new calf --out OUT/calf", "run IN/box.toml --steps 2 --film OUT/f.mp4", "help methods"})
    commands.push_back({more, std::string(more) + (more[0] == 'h' ? "" : " --overwrite")});
  for (const WritingCommand& command : commands)
    folder.prepare(command);
  constexpr int is_endless = 124, not_loaded = 127, first_signal = 129, stopped_by_timeout = 137;
  int n_hangs = 0, n_signals = 0, n_runs = 0;
  for (const auto& [limit, values] : {std::pair<std::string, std::vector<int>>{"-d", {30, 64, 150}},
                                      {"-v", {16, 150, 900}},
                                      {"-s", {64, 1024}},
                                      {"-n", {4, 7}},
                                      {"-f", {1, 20}}})
    for (const int value : values) {
      const int argument = limit == "-d" || limit == "-v" ? 1024 * value : value;
      const std::string before =
          fmt::format("timeout -k 1 30 sh -c 'ulimit {} {}; exec \"$@\"' sh", limit, argument);
      if (const int bare = folder.run("--version", before).code; bare != 0 && bare != 1)
        continue; // the system's loader ends it before main
      for (const WritingCommand& command : commands) {
        const Outcome run = folder.run(command.arguments, before);
        const bool hangs = run.code == is_endless || run.code == stopped_by_timeout;
        const bool has_died = !hangs && run.code >= first_signal;
        n_hangs += hangs;
        n_signals += has_died;
        ++n_runs;
        EXPECT_FALSE(hangs || has_died)
            << command.name << " under ulimit " << limit << ' ' << argument << ": " << run.code << '\n'
            << run.err;
        EXPECT_TRUE(run.code == command.exit_code || run.code == not_loaded || !run.err.empty() ||
                    run.code == 1)
            << command.name << " under ulimit " << limit << ' ' << argument << ": no word of why";
      }
    }
  EXPECT_GT(n_runs, 0);
  fmt::print("hangs_under_limits {} of {} runs\nsignals_under_limits {} of {} runs\n", n_hangs, n_runs,
             n_signals, n_runs);
}

} // namespace
} // namespace maille
