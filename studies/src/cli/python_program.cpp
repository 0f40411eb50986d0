/// Programs in Python that continue a command: statistics, fits, reports.
///
/// C++ checks the command line, does the measurements and protects inputs. It then replaces its process by
/// the program `maille-NAME`, which is stored next to the plugins (python/program.py.in) and runs the module
/// `maille._NAME`. The request is one JSON object on its standard input.

#include "cli/commands.hpp"
#include "maille/plugins/open_plugin.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <sys/mman.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

namespace maille::studies {
namespace {

/// File names may be invalid UTF-8. Python represents such a byte b by the surrogate U+DC00 + b (PEP 383),
/// which JSON can write, but not from a text: the byte is marked, and the mark is replaced in the document.
constexpr std::string_view mark = "\x01\x02", mark_in_json = "\\u0001\\u0002";

/// Number of bytes of the first UTF-8 character; 0: invalid.
std::size_t length_of_character(std::string_view text) {
  if (static_cast<signed char>(text[0]) >= 0)
    return 1;
  for (std::size_t n = 2; n <= std::min<std::size_t>(4, text.size()); ++n)
    if (nlohmann::json::accept(fmt::format("\"{}\"", text.substr(0, n))))
      return n;
  return 0;
}

void mark_bytes(nlohmann::ordered_json& value) {
  if (value.is_structured())
    for (auto& one : value)
      mark_bytes(one);
  if (!value.is_string())
    return;
  std::string marked;
  for (std::string_view text = value.get_ref<const std::string&>(); !text.empty();) {
    const std::size_t n = length_of_character(text);
    marked += n > 0 ? std::string(text.substr(0, n))
                    : fmt::format("{}{:02x}", mark, static_cast<unsigned char>(text[0]));
    text.remove_prefix(n > 0 ? n : 1);
  }
  value = marked;
}

std::string request_text(nlohmann::ordered_json request) {
  mark_bytes(request);
  std::string text = json_text(request);
  for (std::size_t at = 0; (at = text.find(mark_in_json, at)) != std::string::npos;)
    text.replace(at, mark_in_json.size(), "\\udc");
  return text;
}

} // namespace

int become_python_program(const std::string& name, const nlohmann::ordered_json& request) {
  const std::string program = "maille-" + name;
  std::string file = find_plugin(program.c_str(), name + " needs the program",
                                 "; a build with the Python module makes it (python3, pybind11)");
  nlohmann::ordered_json whole = request;
  if (const int signal = stop_signal())
    whole["stopped_by"] = {signal};
  const std::string text = request_text(std::move(whole));
  const int memory = memfd_create("request", 0);
  if (memory < 0 || write(memory, text.data(), text.size()) != static_cast<ssize_t>(text.size()) ||
      lseek(memory, 0, SEEK_SET) != 0 || dup2(memory, STDIN_FILENO) < 0)
    throw std::runtime_error(fmt::format("cannot pass the request to {}: {}", file, std::strerror(errno)));
  close(memory);
  say_file_warnings();
  std::fflush(nullptr);
  const itimerval none{}; // a timer of stop_signals.cpp would otherwise end the program
  setitimer(ITIMER_PROF, &none, nullptr);
  char* const words[] = {file.data(), nullptr};
  execv(file.c_str(), words);
  throw std::runtime_error(
      fmt::format("{} needs the program {}, which cannot be started: {}", name, file, std::strerror(errno)));
}

int run_python_program(const std::string& name, const nlohmann::ordered_json& request) {
  std::fflush(nullptr);
  const pid_t process = fork();
  if (process == 0)
    become_python_program(name, request);
  int status = 0;
  if (process < 0 || waitpid(process, &status, 0) < 0)
    throw std::runtime_error(fmt::format("{} cannot be started: {}", name, std::strerror(errno)));
  return WIFEXITED(status) ? WEXITSTATUS(status) : exit_run_failed;
}

} // namespace maille::studies
