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

/// Prints to stderr; if that fails too, only the exit code reports the error.
void complain(const std::string& message) {
  std::fputs((for_terminal(message) + "\n").c_str(), stderr);
}

/// Reports an error; an error on this rank only must not leave the others waiting.
int fail(std::string_view message, int exit_code) {
  complain(fmt::format("maille: {}", message));
  maille::fem_ref::abort_ranks(exit_code);
  return exit_code;
}

/// The command on the command line. Several ranks share finite elements and the objects of pictures, which
/// only these commands use; the first rank does everything else alone.
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
  std::reverse(words.begin(), words.end()); // the parser expects reverse order
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

/// With a memory limit (`ulimit -v`, `ulimit -d`), threads of OpenBLAS request their buffers for ever, and
/// the library waits for them when the process forks or ends. @return true if the environment was changed,
/// which the library reads while it is loaded
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

/// Raises a low stack limit (`ulimit -s`) as far as the hard limit permits; a stack overflow ends the process
/// by a signal. @return true if it was raised: stacks of threads have the limit of the start of the process
bool raise_stack_limit() {
  constexpr rlim_t least = rlim_t{512} << 10, usual = rlim_t{8} << 20;
  rlimit limit{};
  if (getrlimit(RLIMIT_STACK, &limit) != 0 || limit.rlim_cur >= least)
    return false;
  const rlimit raised{std::min(limit.rlim_max, usual), limit.rlim_max};
  if (raised.rlim_cur < least || setrlimit(RLIMIT_STACK, &raised) != 0) {
    constexpr std::string_view message = "maille: expected a stack limit (ulimit -s) of 512 KiB or more\n";
    static_cast<void>(!write(STDERR_FILENO, message.data(), message.size())); // needs almost no stack
    std::_Exit(exit_run_failed);
  }
  return true;
}

/// Opens standard streams that the caller has closed; otherwise the first opened file would get that
/// descriptor, and messages would be written to it. Writing to a closed standard output stays an error;
/// messages are lost.
void open_standard_streams() {
  for (int descriptor = 0; descriptor < 3; ++descriptor)
    if (fcntl(descriptor, F_GETFD) == -1 && open("/dev/null", descriptor == 2 ? O_WRONLY : O_RDONLY) == -1)
      std::_Exit(exit_run_failed);
}

/// Flushes output and reports a failure, which would be silent at process exit, for example on a full disk.
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
  std::signal(SIGXFSZ, SIG_IGN); // a file size limit then becomes a reported write error
  std::signal(SIGPIPE, SIG_IGN); // the same for a closed reader
  catch_stop_signals();
  bool is_shared = false;
  try {
    const bool has_raised = raise_stack_limit();
    if (limit_blas_threads() || has_raised)
      execv("/proc/self/exe", argv); // goes on where that cannot be
    const std::vector<std::string> words = in_parsers_words({argv + 1, argv + argc});
    // The laboratory is no longer a command; external scripts with the old words get its new place.
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
      reports_failure(); // other ranks wait for errors before the scene is read
    return leave(with_all_output(code));
  } catch (const maille::InputError& error) {
    say_file_warnings();
    if (is_shared && have_all_met()) { // other ranks have read it and wait for this rank
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
