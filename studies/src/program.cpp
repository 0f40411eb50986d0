#include "program.hpp"

#include <array>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <utility>

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
  return std::system(("command -v " + shell_word(name) + " > /dev/null 2>&1").c_str()) == 0;
}

std::optional<std::string> output_of(const std::string& line) {
  std::FILE* const output = popen(line.c_str(), "r");
  if (output == nullptr)
    return std::nullopt;
  std::string text;
  std::array<char, 1 << 14> some{};
  for (std::size_t n = 0; (n = std::fread(some.data(), 1, some.size(), output)) > 0;)
    text.append(some.data(), n);
  return pclose(output) == 0 ? std::optional(std::move(text)) : std::nullopt;
}

std::optional<int> run_program(const std::string& line, const std::function<bool()>& should_stop) {
  std::string shell = "sh", option = "-c", command = line;
  const std::array<char*, 4> words{shell.data(), option.data(), command.data(), nullptr};
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP); // a group of its own, to be ended as one
  pid_t process = 0;
  const int error = posix_spawn(&process, "/bin/sh", nullptr, &attributes, words.data(), environ);
  posix_spawnattr_destroy(&attributes);
  if (error != 0)
    return 127;
  bool is_killed = false;
  for (int status = 0;; std::this_thread::sleep_for(std::chrono::milliseconds(is_killed ? 1 : 20))) {
    if (waitpid(process, &status, WNOHANG) == process) {
      if (is_killed)
        return std::nullopt;
      return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
    }
    if (!is_killed && should_stop()) {
      kill(-process, SIGKILL);
      is_killed = true;
    }
  }
}

} // namespace maille::studies
