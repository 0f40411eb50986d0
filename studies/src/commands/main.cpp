/// The `maille` command: reads the command line, calls one command, turns errors into exit codes.

#include "cli/commands.hpp"
#include "cli/help.hpp"
#include "cli/inputs.hpp"
#include "export/whole_file.hpp"
#include "maille/fem_ref/ranks.hpp"
#include "maille/images/image.hpp"
#include "maille/materials/fault.hpp"
#include "maille/materials/text_file.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <new>
#include <string_view>
#include <sys/resource.h>
#include <unistd.h>

namespace {

using namespace maille::studies;

/// Where nothing can be written to standard error either, the exit code alone says it.
void complain(const std::string& message) {
  std::fputs((for_terminal(message) + "\n").c_str(), stderr);
}

/// What only this rank has met must not leave the others waiting.
int fail(std::string_view message, int exit_code) {
  complain(fmt::format("maille: {}", message));
  maille::fem_ref::abort_ranks(exit_code);
  return exit_code;
}

/// Several ranks share finite elements and the objects of pictures, which only these commands ask for;
/// anything else the first does alone.
std::string command_in(const std::vector<std::string>& words) {
  const auto word = std::ranges::find_if(words, [](const std::string& one) { return one != "--sandbox"; });
  return word == words.end() ? "" : *word;
}

bool is_for_all_ranks(int argc, char** argv) {
  const std::string command = command_in(in_parsers_words({argv + 1, argv + argc}));
  return command == "compare" || command == "run" || command == "render";
}

int run(int argc, char** argv) {
  if (!maille::fem_ref::ranks().is_first() && !is_for_all_ranks(argc, argv))
    return exit_done;
  int code = exit_done;
  const auto app = whole_command_line(code);
  keep_command_line(argc, argv);
  std::string hint;
  std::vector<std::string> words = in_parsers_words({argv + 1, argv + argc}, &hint);
  if (!hint.empty())
    complain(hint);
  if (words.size() == 2 && words[1] == "--help")
    if (const auto text = help_topic(words[0])) {
      fmt::print("{}", *text);
      return exit_done;
    }
  if (argc > 2 && std::string_view(argv[1]) == "help")
    if (const auto wrong = unknown_topic(*app, argv[2]))
      return fail(*wrong, exit_faulty_input);
  std::reverse(words.begin(), words.end()); // as the parser takes a vector
  try {
    app->parse(words);
  } catch (const CLI::ParseError& error) {
    if (!reports_failure())
      return error.get_exit_code() == 0 ? exit_done : exit_faulty_input;
    return app->exit(error) == 0 ? exit_done : exit_faulty_input;
  }
  return code;
}

bool is_limited(decltype(RLIMIT_AS) resource) {
  rlimit limit{};
  return getrlimit(resource, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY;
}

/// Under a limit of memory (`ulimit -v`, `ulimit -d`) threads of OpenBLAS ask for their buffers without end,
/// and that library waits for them as the process forks or ends. @return whether the environment was changed,
/// which that library reads while it is loaded
bool limit_blas_threads() {
  constexpr const char* variable = "OPENBLAS_NUM_THREADS";
  const char* const threads = std::getenv(variable);
  if ((!is_limited(RLIMIT_AS) && !is_limited(RLIMIT_DATA)) ||
      (threads != nullptr && std::string_view(threads) == "1"))
    return false;
  setenv(variable, "1", 1);
  setenv("MALLOC_ARENA_MAX", "1", 0); // else every thread reserves 64 MiB for its own
  return true;
}

/// Raises a low limit of the stack (`ulimit -s`) as far as the hard limit permits; a stack that is too small
/// ends the process by a signal. @return whether it was raised: stacks of threads have the size that the
/// limit had when the process started
bool raise_stack_limit() {
  constexpr rlim_t least = rlim_t{512} << 10, usual = rlim_t{8} << 20;
  rlimit limit{};
  if (getrlimit(RLIMIT_STACK, &limit) != 0 || limit.rlim_cur >= least)
    return false;
  const rlimit raised{std::min(limit.rlim_max, usual), limit.rlim_max};
  if (raised.rlim_cur < least || setrlimit(RLIMIT_STACK, &raised) != 0) {
    constexpr std::string_view message = "maille: expected a stack limit (ulimit -s) of 512 KiB or more\n";
    static_cast<void>(!write(STDERR_FILENO, message.data(), message.size())); // takes next to no stack
    std::_Exit(exit_run_failed);
  }
  return true;
}

/// Where the caller closed one of the first three, the first file that is opened would take its place, and
/// messages would end in it. Of standard output it stays an error to write there; messages have nowhere to
/// go.
void open_standard_streams() {
  for (int descriptor = 0; descriptor < 3; ++descriptor)
    if (fcntl(descriptor, F_GETFD) == -1 && open("/dev/null", descriptor == 2 ? O_WRONLY : O_RDONLY) == -1)
      std::_Exit(exit_run_failed);
}

/// What is still in a buffer when the process ends would be lost without a word where the disk is full.
int with_all_output(int exit_code) {
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
    return fail("cannot write to standard output", exit_run_failed);
  return exit_code;
}

} // namespace

void maille::studies::say_file_warnings() {
  const std::vector<std::string> warnings = maille::file_warnings(true);
  if (maille::fem_ref::ranks().is_first())
    for (const std::string& warning : warnings)
      complain("warning: " + warning);
}

int main(int argc, char** argv) {
  open_standard_streams();
  std::signal(SIGXFSZ, SIG_IGN); // a limit of a file's size is then an error of writing, and said as such
  std::signal(SIGPIPE, SIG_IGN); // likewise a reader that has gone
  catch_stop_signals();
  bool is_shared = false;
  try {
    const bool has_raised = raise_stack_limit();
    if (limit_blas_threads() || has_raised)
      execv("/proc/self/exe", argv); // goes on where that cannot be
    const std::vector<std::string> words = in_parsers_words({argv + 1, argv + argc});
    // The laboratory has left the command; outside scripts that still use the old words are told where it is.
    if (!words.empty() && (words[0] == "bench" || words[0] == "verify" || words[0] == "stability"))
      throw UsageError(fmt::format("maille {} is now studies/lab/run {} of the source tree", words[0],
                                   words[0] == "bench" ? "SUBJECT" : words[0]));
    maille::keep_opened_files();
    maille::fem_ref::start_ranks();
    is_shared = is_for_all_ranks(argc, argv);
    if (!ranks_agree({{"command", is_shared ? command_in(words) : "(of the first rank alone)"}}))
      return exit_faulty_input;
    if (!is_shared)
      meet_no_more();
    const int code = run(argc, argv);
    say_file_warnings();
    if (is_shared)
      reports_failure(); // the others wait for a word of what ended before the scene was read
    return leave(with_all_output(code));
  } catch (const maille::InputError& error) {
    say_file_warnings();
    if (is_shared && have_all_met()) { // the others are past reading and wait for this rank
      complain(error.what());
      maille::fem_ref::abort_ranks(exit_faulty_input);
    } else if (reports_failure())
      complain(error.what());
    return leave(exit_faulty_input);
  } catch (const UsageError& error) {
    return leave(fail(error.what(), exit_faulty_input));
  } catch (const FolderTaken& error) { // a foreign file under the name of a result
    return leave(fail(error.what(), exit_faulty_input));
  } catch (const std::bad_alloc&) {
    return leave(fail("out of memory", exit_run_failed));
  } catch (const std::exception& error) {
    return leave(fail(message_of(error), exit_run_failed));
  }
}
