#include "bench/ecosystem/startup.hpp"

#include "maille/materials/text_file.hpp"
#include "median.hpp"
#include "program.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>

#include <fcntl.h>
#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

namespace maille::lab {
namespace {

namespace fs = std::filesystem;

/// `maille` itself, above the program that runs: in the build tree, and where it is installed.
fs::path command_file() {
  const fs::path own = fs::read_symlink("/proc/self/exe");
  for (fs::path folder = own.parent_path(); folder != folder.root_path(); folder = folder.parent_path())
    for (const fs::path& file : {folder / "maille", folder / "bin/maille"})
      if (fs::is_regular_file(file))
        return file;
  throw std::runtime_error("there is no maille beside or above " + own.string());
}

/// Becomes the program, without output.
[[noreturn]] void become(const std::vector<std::string>& words) {
  std::vector<char*> arguments;
  for (const std::string& word : words)
    arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const int nowhere = open("/dev/null", O_WRONLY);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
  execv(arguments.front(), arguments.data());
  _exit(127);
}

/// [ms] from the fork to the end.
double milliseconds_of(const std::vector<std::string>& words) {
  const auto begin = std::chrono::steady_clock::now();
  const pid_t child = fork();
  if (child == 0)
    become(words);
  int status = 0;
  waitpid(child, &status, 0);
  if (child < 0 || status != 0)
    throw std::runtime_error("cannot run " + words.front());
  return 1e3 * std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// [MiB] that were resident at once: VmHWM where the process is about to end. getrusage would count what this
/// program holds, too, whose memory the child has until it becomes another. Nothing where it cannot be
/// watched.
std::optional<double> peak_of(const std::vector<std::string>& words) {
  const pid_t child = fork();
  if (child == 0) {
    ptrace(PTRACE_TRACEME, 0, nullptr, nullptr);
    become(words);
  }
  std::optional<double> peak;
  int status = 0;
  bool is_watched = false;
  while (waitpid(child, &status, 0) == child && WIFSTOPPED(status)) {
    if (!is_watched) // it has just become the program
      is_watched = ptrace(PTRACE_SETOPTIONS, child, nullptr, PTRACE_O_TRACEEXIT | PTRACE_O_EXITKILL) == 0;
    else if (status >> 8 == (SIGTRAP | (PTRACE_EVENT_EXIT << 8))) {
      std::ifstream lines(fmt::format("/proc/{}/status", child));
      for (std::string line; std::getline(lines, line);)
        if (line.starts_with("VmHWM:"))
          peak = std::stod(line.substr(6)) / 1024;
    }
    ptrace(PTRACE_CONT, child, nullptr, nullptr);
  }
  return peak;
}

void measure(const char* what, const std::vector<std::string>& words, int repeats, BenchReport& report) {
  std::vector<double> times;
  for (int i = 0; i < repeats; ++i)
    times.push_back(milliseconds_of(words));
  const auto peak = peak_of(words);
  report.add({{"what", what},
              {"milliseconds", upper_median(times)},
              {"least", *std::ranges::min_element(times)},
              {"mib", peak ? nlohmann::ordered_json(*peak) : nlohmann::ordered_json()}});
}

/// Objects of the target that scripts/demo builds, from the build tree; nothing without one.
std::optional<double> objects_of_demo() {
  const fs::path build = MAILLE_BUILD;
  if (!has_program("ninja") || !fs::exists(build / "build.ninja"))
    return std::nullopt;
  const auto commands =
      output_of(fmt::format("ninja -C {} -t commands maille_command", shell_word(build.string())));
  if (!commands)
    return std::nullopt;
  double n_objects = 0;
  for (std::size_t at = 0; (at = commands->find(" -c ", at)) != std::string::npos; ++at)
    ++n_objects;
  return n_objects;
}

constexpr const char* bar = R"([specimen]
shape = "box"
cells = [4, 2, 2]
spacing = "1 mm"
material = "muscle/soleus"
[test]
kind = "axial"
axis = "x"
strain = "1 %"
)";

} // namespace

void bench_start(const BenchOptions& options, BenchReport& report) {
  const std::string maille = command_file();
  const WorkFolder folder("maille");
  const std::string scene = folder.path() / "bar.toml";
  std::ofstream(scene) << bar;
  const int repeats = options.quick ? 5 : 31;
  measure("--version", {maille, "--version"}, repeats, report);
  const double time = report.rows.back()["milliseconds"];
  const nlohmann::ordered_json memory = report.rows.back()["mib"];
  measure("check", {maille, "check", scene}, repeats, report);
  measure("run by coupled", {maille, "run", scene, "--methods", "coupled"}, repeats, report);
  measure("run by fem_q1, which opens deal.II", {maille, "run", scene, "--methods", "fem_q1"},
          options.quick ? 1 : 5, report);
  report.checks.push_back({"start_ms", time});
  if (memory.is_number())
    report.checks.push_back({"start_mib", memory});
  else
    report.notes.emplace_back("the memory of a process cannot be watched here (ptrace)");
  if (const auto n_objects = objects_of_demo())
    report.checks.push_back({"demo_objects", *n_objects});
  else
    report.notes.emplace_back("no build tree of ninja: objects of scripts/demo are not counted");
}

} // namespace maille::lab
