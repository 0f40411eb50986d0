#include "cli/commands.hpp"
#include "help.hpp"
#include "json_parts.hpp"

#include "compare/methods.hpp"
#include "maille/fem_ref/ranks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <unistd.h>

namespace maille::studies {

namespace {

/// On a terminal, and for the Python module, which reads the line.
bool shows_progress() {
  return fem_ref::ranks().is_first() &&
         (isatty(STDERR_FILENO) == 1 || std::getenv("MAILLE_PROGRESS") != nullptr);
}

} // namespace

Control terminal_control(int threads) {
  hear_stop_signals();
  Control control;
  control.threads = threads;
  control.stop_requested = [] { return stop_signal() != 0; };
  if (shows_progress()) {
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
  if (shows_progress())
    fmt::print(stderr, "\r\033[K");
}

std::vector<std::string> default_compare_methods() {
  return {"limits", "relaxed", "coupled", "fem_q1"};
}

std::vector<std::string> check_methods(const std::vector<std::string>& methods, const std::string& option) {
  std::vector<std::string> once;
  for (const std::string& method : methods) {
    if (!is_method(method))
      throw UsageError(fmt::format("{}: expected {} of {}, found \"{}\"{}", option,
                                   option == "--methods" ? "some" : "one", fmt::join(all_methods(), ", "),
                                   method, did_you_mean(method, all_methods())));
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
  return provenance_with({{"scene", scene.name},
                          {"title", scene.title},
                          {"method", answer.method},
                          {"algorithm", answer.algorithm},
                          {"status", to_string(answer.status)},
                          {"threads", threads}});
}

} // namespace maille::studies
