/// Programs in Python that continue a command: statistics, fits, reports.
///
/// C++ checks the command line, measures and keeps inputs safe. It then replaces its process by the program
/// `maille-NAME`, which stands beside the plugins (python/program.py.in) and runs the module `maille._NAME`.
/// The request is one JSON object on the program's standard input; standard output, standard error, locks of
/// folders and the exit code are those of the command.

#include "cli/commands.hpp"
#include "maille/plugins/open_plugin.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <sys/mman.h>
#include <sys/time.h>
#include <unistd.h>

namespace maille::studies {

int become_python_program(const std::string& name, const nlohmann::ordered_json& request) {
  const std::string program = "maille-" + name;
  std::string file = find_plugin(program.c_str(), name + " needs the program",
                                 "; a build with the Python module makes it (python3, pybind11)");
  const std::string text = json_text(request);
  const int memory = memfd_create("request", 0);
  if (memory < 0 || write(memory, text.data(), text.size()) != static_cast<ssize_t>(text.size()) ||
      lseek(memory, 0, SEEK_SET) != 0 || dup2(memory, STDIN_FILENO) < 0)
    throw std::runtime_error(fmt::format("cannot pass the request to {}: {}", file, std::strerror(errno)));
  close(memory);
  say_file_warnings();
  std::fflush(nullptr);
  const itimerval none{}; // a timer of stop_signals.cpp would go on, and end the program
  setitimer(ITIMER_PROF, &none, nullptr);
  char* const words[] = {file.data(), nullptr};
  execv(file.c_str(), words);
  throw std::runtime_error(
      fmt::format("{} needs the program {}, which cannot be started: {}", name, file, std::strerror(errno)));
}

} // namespace maille::studies
