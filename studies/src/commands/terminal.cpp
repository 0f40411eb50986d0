#include "commands.hpp"
#include "help.hpp"

#include "maille/fem_ref/ranks.hpp"
#include "maille/studies/methods.hpp"
#include "maille/studies/version.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <unistd.h>

namespace maille::studies {

namespace {

std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may touch it");

/// What follows within this time is the same Ctrl-C: timeout and mpirun send it to a process and to its group.
constexpr long same_interrupt_ns = 200'000'000;
timespec first_interrupt{};

/// The first Ctrl-C asks methods to end in a usable state; a second one ends the process as usual.
void on_interrupt(int) {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now); // a handler may call it
  if (!interrupted) {
    first_interrupt = now;
    interrupted = true;
  } else if ((now.tv_sec - first_interrupt.tv_sec) * 1'000'000'000L + now.tv_nsec - first_interrupt.tv_nsec >
             same_interrupt_ns) {
    std::signal(SIGINT, SIG_DFL);
    raise(SIGINT);
  }
}

bool stderr_is_terminal() {
  return fem_ref::ranks().is_first() && isatty(STDERR_FILENO) == 1;
}

} // namespace

Control terminal_control(int threads) {
  std::signal(SIGINT, on_interrupt);
  Control control;
  control.threads = threads;
  control.stop_requested = [] { return interrupted.load(); };
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
  return nlohmann::ordered_json{
      {"maille", version},       {"scene", scene.name},           {"title", scene.title},
      {"method", answer.method}, {"algorithm", answer.algorithm}, {"status", to_string(answer.status)},
      {"threads", threads}}
      .dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

} // namespace maille::studies
