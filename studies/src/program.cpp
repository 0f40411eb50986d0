#include "program.hpp"

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <thread>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

namespace maille::studies {

std::string shell_word(std::string_view text) {
  std::string word = "'";
  for (const char c : text)
    word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

bool has_program(std::string_view name) {
  return run_program("command -v " + shell_word(name) + " > /dev/null 2>&1") == 0;
}

namespace {

std::array<std::atomic<pid_t>, 32> running_groups{};
std::atomic<bool> are_ended{false};
static_assert(std::atomic<pid_t>::is_always_lock_free, "a signal handler may touch it");

/// A shell in its own process group, registered for end_programs() in its lifetime.
class Program {
public:
  explicit Program(const std::string& line) {
    std::string shell = "sh", option = "-c", command = line;
    const std::array<char*, 4> words{shell.data(), option.data(), command.data(), nullptr};
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
    sigset_t usual;
    sigemptyset(&usual);
    sigaddset(&usual, SIGPIPE);
    posix_spawnattr_setsigdefault(&attributes, &usual);
    if (posix_spawn(&process_, "/bin/sh", nullptr, &attributes, words.data(), environ) != 0)
      process_ = -1;
    posix_spawnattr_destroy(&attributes);
    for (std::atomic<pid_t>& group : running_groups)
      if (pid_t none = 0; has_started() && group.compare_exchange_strong(none, process_)) {
        place_ = &group;
        break;
      }
    if (are_ended)
      end();
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;
  ~Program() { forget(); }

  bool has_started() const { return process_ > 0; }
  void end() const {
    if (has_started())
      kill(-process_, SIGKILL);
  }
  /// Exit code, 128 + N for signal N. @param options  WNOHANG: nothing while it runs
  std::optional<int> wait(int options = 0) {
    int status = 0;
    pid_t found = 0;
    while ((found = waitpid(process_, &status, options)) < 0 && errno == EINTR) {
    }
    if (found == 0)
      return std::nullopt;
    forget();
    return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  }

private:
  void forget() {
    if (place_ != nullptr)
      *place_ = 0;
    place_ = nullptr;
  }

  pid_t process_ = -1;
  std::atomic<pid_t>* place_ = nullptr;
};

} // namespace

void end_programs() noexcept {
  are_ended = true;
  for (const std::atomic<pid_t>& group : running_groups)
    if (const pid_t process = group; process > 0)
      kill(-process, SIGKILL);
}

std::optional<int> run_program(const std::string& line, const std::function<bool()>& should_stop) {
  Program program(line);
  if (!program.has_started())
    return 127;
  if (!should_stop)
    return program.wait();
  for (bool is_killed = false;; std::this_thread::sleep_for(std::chrono::milliseconds(is_killed ? 1 : 20))) {
    if (const auto code = program.wait(WNOHANG))
      return is_killed ? std::nullopt : code;
    if (!is_killed && should_stop()) {
      program.end();
      is_killed = true;
    }
  }
}

} // namespace maille::studies
