/// Ctrl-C (SIGINT), SIGTERM and SIGHUP in the middle of the work, also sent before the work has begun: the
/// exit code says so, what is complete is there, and what is there is whole.

#include "support/kit.hpp"
#include "writing_commands.hpp"

#include <chrono>
#include <csignal>
#include <ctime>
#include <sys/resource.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace maille {
namespace {

using test::CommandFolder;
using test::Files;
using test::files_in;
using test::Outcome;
using test::WritingCommand;

class InterruptContract : public testing::TestWithParam<WritingCommand> {};

/// Sweeps over these cells would take minutes.
const std::string slow_end =
    "[relaxation]\ntolerance = 1e-12\n[limits]\nfrom = \"given\"\nstretch = 2\ncompress = 0.1\nshear = 1\n";

TEST_P(InterruptContract, EndsSoonWithWholeFilesAndItsExitCode) {
  const CommandFolder folder;
  folder.write("in/slow.toml", CommandFolder::box("[\"2 mm\", 0, 0]", "[60, 60, 60]") + slow_end);
  folder.write("in/slower.toml", CommandFolder::box("[\"1 mm\", 0, 0]", "[60, 60, 60]") + slow_end);
  folder.write("in/slow_study.toml", "scene = \"slow.toml\"\nmethods = [\"sweep\"]\nreference = \"none\"\n");
  const Files before{{"earlier.json", "{}"}};
  folder.write("out/earlier.json", "{}");
  // While libraries are loaded; during the work, also under load.
  for (const auto& [signal, number, seconds] :
       {std::tuple{"INT", 2, "0.05"}, std::tuple{"INT", 2, "4"}, std::tuple{"TERM", 15, "4"}}) {
    const Outcome run = folder.run(GetParam().arguments,
                                   fmt::format("timeout --preserve-status -s {} -k 60 {}", signal, seconds));
    EXPECT_EQ(run.code, 128 + number) << signal << " after " << seconds << " s: " << run.err;
    for (const auto& [name, text] : files_in(folder.out()))
      EXPECT_TRUE(test::is_whole(name, text, text)) << signal << " after " << seconds << " s: " << name;
    for (const auto& [name, text] : files_in(folder.out(), true))
      ADD_FAILURE() << signal << " after " << seconds << " s: " << name << " is left over";
    EXPECT_EQ(test::text_of(folder.out() / "earlier.json"), "{}");
  }
}

INSTANTIATE_TEST_SUITE_P(
    Commands, InterruptContract,
    testing::Values(
        WritingCommand{"run", "run IN/slow.toml --methods sweep --out OUT --json OUT/r.json"},
        WritingCommand{"compare", "compare IN/slow.toml --methods sweep --reference sweep --out OUT"},
        WritingCommand{"study", "study IN/slow_study.toml --resume --out OUT"},
        WritingCommand{"trade", "study trade IN/slow.toml --methods sweep --spacings 1 --tolerances 0.0001 "
                                "--reference sweep --out OUT"},
        WritingCommand{"fit", "fit IN/slow.toml --test IN/slower.toml --reference sweep --out OUT/m.toml"}),
    [](const auto& one) { return one.param.name; });

/// A factor of these cells, and the analysis before it, take far longer than a test may.
const std::string far_too_many = "[44, 44, 44]";
const std::string wide_limits = "[limits]\nfrom = \"given\"\nstretch = 2\ncompress = 0.1\nshear = 1\n";

class FactorContract : public testing::TestWithParam<std::string> {};

// No library that factorises can be asked to stop. What was answered before is there, and the rest says that
// it was cut.
TEST_P(FactorContract, IsLeftWithinASecondAndWhatIsCompleteIsKept) {
  const CommandFolder folder;
  folder.write("in/large.toml", CommandFolder::box("[\"1 mm\", 0, 0]", far_too_many) + wide_limits);
  const double before_the_signal = 9;
  const auto start = std::chrono::steady_clock::now();
  const Outcome run = folder.run(
      "compare IN/large.toml --methods coupled,fem_q1 --fem-solver cholmod --threads 1 --json OUT/r.json",
      fmt::format("timeout --preserve-status -s {} -k 60 {}", GetParam(), before_the_signal));
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  const std::map<std::string, int> numbers{{"HUP", 1}, {"INT", 2}, {"TERM", 15}};
  EXPECT_EQ(run.code, 128 + numbers.at(GetParam())) << run.err;
  EXPECT_LT(took.count(), before_the_signal + 3) << "one second, and two for a busy machine";
  const auto results = nlohmann::json::parse(test::text_of(folder.out() / "r.json"))["results"];
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(results[0]["method"], "coupled");
  EXPECT_EQ(results[0]["status"], "done");
  EXPECT_EQ(results[1]["method"], "fem_q1");
  EXPECT_EQ(results[1]["status"], "interrupted");
  EXPECT_TRUE(test::has(run.out, "interrupted"));
  EXPECT_TRUE(files_in(folder.out(), true).empty());
}

INSTANTIATE_TEST_SUITE_P(Signals, FactorContract, testing::Values("INT", "TERM", "HUP"),
                         [](const auto& one) { return one.param; });

// Nothing of a reference that was cut short is written or measured against.
TEST(InterruptedReferenceContract, LeavesNoFileAndTheTextSaysSo) {
  const CommandFolder folder;
  // Small enough for its file to be written within the second, while its reference takes much longer.
  folder.write("in/large.toml", CommandFolder::box("[\"1 mm\", 0, 0]", "[28, 28, 28]") + wide_limits);
  const Outcome run =
      folder.run("compare IN/large.toml --methods coupled --fem-solver cholmod --reference best "
                 "--reference-seconds 1000 --threads 1 --out OUT",
                 "timeout --preserve-status -s INT -k 60 9");
  EXPECT_EQ(run.code, 128 + 2) << run.err;
  EXPECT_TRUE(std::filesystem::exists(folder.out() / "large_coupled.vti")) << run.out;
  EXPECT_FALSE(std::filesystem::exists(folder.out() / "large_best.vti")) << run.out;
  EXPECT_FALSE(test::has(run.out, "could be afforded")) << run.out;
  EXPECT_TRUE(test::has(run.out, "it ended interrupted"));
}

// A table of nothing is worth less than that of an earlier run.
TEST(InterruptedReferenceContract, WithoutAnAnswerEarlierFilesStay) {
  const CommandFolder folder;
  folder.write("in/large.toml", CommandFolder::box("[\"1 mm\", 0, 0]", far_too_many) + wide_limits);
  const Files earlier{{"c.csv", "precious"}, {"r.json", "{}"}}; // of others: --overwrite
  for (const auto& [name, text] : earlier)
    folder.write("out/" + name, text);
  const Outcome run = folder.run("compare IN/large.toml --methods fem_q1 --fem-solver cholmod --threads 1 "
                                 "--json OUT/r.json --csv OUT/c.csv --overwrite",
                                 "timeout --preserve-status -s INT -k 60 4");
  EXPECT_EQ(run.code, 128 + 2) << run.err;
  EXPECT_TRUE(test::has(run.err, "earlier files stay"));
  EXPECT_EQ(files_in(folder.out()), earlier);
}

struct Stopped {
  double seconds = 0; ///< of processor, from the signal to the end
  int code = -1;      ///< exit code, 128 + N for signal N
  bool was_running = false;
};

/// @param after  seconds of processor before the signal
Stopped stop_after(const std::string& line, double after, int signal) {
  const pid_t process = fork();
  if (process == 0) {
    execl("/bin/sh", "sh", "-c", ("exec " + line + " > /dev/null 2>&1").c_str(), nullptr);
    _exit(127);
  }
  clockid_t clock{};
  clock_getcpuclockid(process, &clock);
  const auto used = [&] {
    timespec time{};
    return clock_gettime(clock, &time) == 0 ? double(time.tv_sec) + 1e-9 * double(time.tv_nsec) : after;
  };
  siginfo_t info{};
  Stopped result;
  const auto has_ended = [&] {
    return waitid(P_PID, static_cast<id_t>(process), &info, WEXITED | WNOHANG | WNOWAIT) != 0 ||
           info.si_pid == process;
  };
  while (used() < after && !has_ended())
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  // wait4() counts programs that the process has started and waited for; its clock does not.
  const auto of_programs = [&] {
    std::string text = test::text_of(fmt::format("/proc/{}/stat", process));
    std::istringstream fields(text.substr(std::min(text.rfind(')') + 1, text.size())));
    std::string skipped;
    for (int field = 3; field < 16; ++field)
      fields >> skipped;
    double user = 0, system = 0;
    fields >> user >> system;
    return (user + system) / double(sysconf(_SC_CLK_TCK));
  };
  const double before = used() + of_programs();
  result.was_running = !has_ended();
  kill(process, signal);
  int status = 0;
  rusage usage{};
  wait4(process, &status, 0, &usage);
  for (const timeval& time : {usage.ru_utime, usage.ru_stime})
    result.seconds += double(time.tv_sec) + 1e-6 * double(time.tv_usec);
  result.seconds -= before;
  result.code = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  return result;
}

// Signals at seeded moments fall into reading, the method, mechanics, files and pictures.
TEST(StopTimeContract, EveryPhaseEndsWithinASecondOfProcessor) {
  const CommandFolder folder;
  const auto scene = [&](const char* name, const std::string& cells) {
    folder.write(std::string("in/") + name, CommandFolder::box("[\"0.5 mm\", 0, 0]", cells));
    return (folder.in() / name).string();
  };
  const std::string large = scene("large.toml", "[90, 60, 60]"), small = scene("small.toml", "[30, 20, 20]"),
                    out = folder.out().string(), maille = MAILLE_COMMAND;
  folder.write("in/falls.toml", "[world]\ncells = [40, 40, 40]\nspacing = \"1 mm\"\ncontact = \"surfaces\"\n"
                                "dynamics = { gravity = [0, 0, \"-9.81 m/s^2\"] }\n" +
                                    test::object_text("body", "deformable", "[20, 20, 10]",
                                                      "material = " + test::soft +
                                                          "\ndensity = 1000\nspacing = \"1 mm\"\n"
                                                          "position = [\"9 mm\", \"9 mm\", 0]\n"));
  folder.write("in/time.toml", "frame_time = \"20 ms\"\nframes = 100\n");
  folder.write("in/many.toml",
               "scene = \"small.toml\"\nmethods = [\"coupled\"]\nreference = \"fem_q1\"\n"
               "[[parameter]]\nkey = \"move[1].by.0\"\nrange = [\"0.1 mm\", \"0.5 mm\"]\ncount = 40\n");
  const std::string world = (folder.in() / "falls.toml").string(),
                    path = (folder.in() / "time.toml").string(), study = (folder.in() / "many.toml").string();
  std::mt19937 lot(41);
  double worst = 0;
  int n_stopped = 0;
  for (const auto& [line, latest] :
       {std::pair{"run " + large + " --methods coupled --threads 1 --out " + out, 4.0},
        {"compare " + large + " --methods limits,coupled --reference coupled --threads 1 --out " + out +
             " --picture " + out + "/c.png",
         6.0},
        {"run " + small + " --methods fem_q1 --threads 1", 3.0},
        {"render " + large + " --threads 1 --width 6000 --height 6000 --samples 16 --out " + out + "/r.png",
         3.0},
        {"run " + small + " --methods coupled --steps 20 --film " + out + "/f.mp4 --threads 1", 3.0},
        {"play " + world + " " + path + " --threads 1 --out " + out, 4.0},
        {"study " + study + " --threads 1 --jobs 1 --out " + out, 4.0}})
    for (int trial = 0; trial < 6; ++trial) {
      const double after = std::uniform_real_distribution(0.1, latest)(lot);
      const int signal = trial % 2 == 0 ? SIGTERM : SIGINT;
      const Stopped run = stop_after(maille + " " + line, after, signal);
      if (!run.was_running || (run.code == 0 && run.seconds < 0.1))
        continue; // it had ended, or was returning from main(): not counted
      ++n_stopped;
      worst = std::max(worst, run.seconds);
      EXPECT_LE(run.seconds, 1) << line << " after " << after << " s";
      EXPECT_EQ(run.code, 128 + signal) << line << " after " << after << " s";
      for (const auto& [name, text] : files_in(folder.out(), true))
        ADD_FAILURE() << line << " after " << after << " s: " << name << " is left over";
    }
  EXPECT_GT(n_stopped, 12);
  fmt::print("seconds_to_stop {:.2f} ({} signals)\n", worst, n_stopped);
}

// A second signal, and one without a handler, end the process at once; incomplete files are removed.
TEST(SignalContract, NoPartOfAFileIsLeftBehind) {
  const CommandFolder folder;
  for (const WritingCommand& command : test::writing_commands()) {
    if (command.name != "report" && command.name != "export")
      continue;
    folder.prepare(command);
    const Outcome run = folder.run_with_fault(command.arguments, "write:1:INT", folder.out());
    EXPECT_EQ(run.code, 128 + 2) << command.name << run.err;
    for (const auto& [name, text] : files_in(folder.out(), true))
      ADD_FAILURE() << command.name << ": " << name << " is left over";
  }
}

} // namespace
} // namespace maille
