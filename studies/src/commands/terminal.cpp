#include "commands.hpp"
#include "stop_signals.hpp"

#include "maille/fem_ref/ranks.hpp"
#include "maille/studies/export/whole_file.hpp"
#include "maille/studies/methods.hpp"
#include "maille/studies/version.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <unistd.h>

namespace maille::studies {

namespace {

bool stderr_is_terminal() {
  return fem_ref::ranks().is_first() && isatty(STDERR_FILENO) == 1;
}

} // namespace

Control terminal_control(int threads) {
  hear_stop_signals();
  Control control;
  control.threads = threads;
  control.stop_requested = is_stop_asked;
  if (stderr_is_terminal()) {
    using Clock = std::chrono::steady_clock;
    control.progress = [last = Clock::time_point{}](double fraction, std::string_view what) mutable {
      if (const auto now = Clock::now(); now - last > std::chrono::milliseconds(100)) {
        last = now;
        fmt::print(stderr, "\r\033[K{:3.0f} %  {}", 100 * fraction, what);
        std::fflush(stderr);
      }
    };
  }
  return control;
}

void end_progress() {
  if (stderr_is_terminal())
    fmt::print(stderr, "\r\033[K");
}

void deliver(const std::string& text, const std::optional<std::string>& file) {
  if (file && *file != "-") {
    write_whole(*file, text);
    return;
  }
  fmt::print("{}", text);
  if (std::fflush(stdout) != 0)
    throw std::runtime_error("cannot write to standard output");
}

void prepare_folder(const std::filesystem::path& folder) {
  try {
    std::filesystem::create_directories(folder);
    const auto probe = folder / ".maille-write-test";
    write_whole(probe, "");
    std::filesystem::remove(probe);
  } catch (const std::exception& error) {
    throw UsageError(
        fmt::format("--out {}: expected a folder that can be written: {}", folder.string(), error.what()));
  }
}

void prepare_file(const std::string& option, const std::optional<std::string>& file) {
  namespace fs = std::filesystem;
  if (!file || *file == "-")
    return;
  const fs::path path(*file);
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  const char* found = nullptr;
  std::error_code error;
  if (path.empty() || fs::is_directory(path, error))
    found = "a folder";
  else if (!fs::is_directory(folder, error))
    found = "no such folder";
  else if (access(folder.c_str(), W_OK) != 0 || (fs::exists(path, error) && access(path.c_str(), W_OK) != 0))
    found = "no permission to write";
  if (found)
    throw UsageError(
        fmt::format("{} {}: expected a file that can be written, found {}", option, *file, found));
}

std::vector<std::string> check_methods(const std::vector<std::string>& methods) {
  std::vector<std::string> once;
  for (const std::string& method : methods) {
    if (!is_method(method))
      throw UsageError(fmt::format("--methods: expected some of {}, found \"{}\"",
                                   fmt::join(all_methods(), ", "), method));
    if (std::find(once.begin(), once.end(), method) == once.end())
      once.push_back(method);
  }
  return once;
}

fem_ref::LinearSolver check_fem_solver(const std::string& name) {
  if (const auto solver = fem_ref::linear_solver_named(name))
    return *solver;
  throw UsageError(fmt::format("--fem-solver: expected one of {}, found \"{}\"",
                               fmt::join(fem_ref::linear_solver_names, ", "), name));
}

std::string provenance(const Scene& scene, const Answer& answer, int threads) {
  return nlohmann::ordered_json{
      {"maille", version},       {"scene", scene.name},           {"title", scene.title},
      {"method", answer.method}, {"algorithm", answer.algorithm}, {"status", to_string(answer.status)},
      {"threads", threads}}
      .dump();
}

} // namespace maille::studies
