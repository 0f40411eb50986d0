/// Less memory, stack or open files than are needed (`ulimit`): a message and an exit code, never a crash or
/// an endless loop, and earlier results stay.

#include "support/sanitized.hpp"
#include "writing_commands.hpp"

namespace maille {
namespace {

using test::CommandFolder;
using test::Files;
using test::files_in;
using test::Outcome;
using test::WritingCommand;

class MemoryContract : public testing::TestWithParam<WritingCommand> {};

TEST_P(MemoryContract, AProcessWithoutMemorySaysSo) {
#ifdef MAILLE_CHECKS_ACCESS
  GTEST_SKIP() << "the sanitizer reserves more address space than any limit leaves";
#endif
  const CommandFolder folder;
  folder.folder().write("in/large.toml", CommandFolder::box("[\"1 mm\", 0, 0]", "[40, 40, 40]"));
  folder.folder().write("in/large_study.toml",
                        "scene = \"large.toml\"\nmethods = [\"relaxed\"]\nreference = \"none\"\n");
  folder.folder().write("out/earlier.json", "{}");
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
                    WritingCommand{"materials", "materials --json OUT/m.json"}),
    [](const auto& one) { return one.param.name; });

// OpenBLAS asks for its buffer without end where the factor has taken the last of the address space.
TEST(BlasMemoryContract, AFactorThatTakesAllThereIsEnds) {
#ifdef MAILLE_CHECKS_ACCESS
  GTEST_SKIP() << "the sanitizer reserves more address space than any limit leaves";
#endif
  const CommandFolder folder;
  folder.folder().write("in/belly.toml", CommandFolder::box("[\"1 mm\", 0, 0]", "[21, 21, 21]"));
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

// Every command that writes, and the two kinds of finite elements, under a ladder of each limit.
TEST(ResourceLimitsContract, NoCommandHangsOrEndsByASignal) {
#ifdef MAILLE_CHECKS_ACCESS
  GTEST_SKIP() << "the sanitizer reserves more address space than any limit leaves";
#endif
  const CommandFolder folder;
  folder.folder().write("in/belly.toml", CommandFolder::box("[\"1 mm\", 0, 0]", "[32, 8, 8]"));
  std::vector<WritingCommand> commands = test::writing_commands();
  for (const char* method : {"fem_q1", "fem_q2"})
    commands.push_back({method, fmt::format("run IN/belly.toml --methods {}", method)});
  commands.push_back({"check", "check IN/box.toml"});
  commands.push_back({"explain", "explain IN/box.toml"});
  commands.push_back({"render", "render IN/box.toml --width 40 --height 40 --out OUT/r.png"});
  for (const WritingCommand& command : commands)
    folder.prepare(command);
  constexpr int is_endless = 124, not_loaded = 127, first_signal = 129, stopped_by_timeout = 137;
  int n_hangs = 0, n_signals = 0, n_runs = 0;
  for (const auto& [limit, values] : {std::pair<std::string, std::vector<int>>{"-d", {30, 64, 150}},
                                      {"-v", {150, 900}},
                                      {"-s", {64, 1024}},
                                      {"-n", {4, 7}}})
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
