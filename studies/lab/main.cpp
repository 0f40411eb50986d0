/// maille-lab SUBJECT [--quick] [--only NAME]... [--threads N]: measures one subject and
/// prints what it found as JSON.
/// studies/lab/run starts it, checks the command line and prints tables.
/// maille-lab --loop LOOP SCENE TRAJECTORY STEM: plays a world by a loop of 1995, into STEM_000.png and on.
/// maille-lab --promises SCENE METHOD [TRAJECTORY]: a row about one answer, or one play.
/// mpirun -n N maille-lab verify --ranks: only what several ranks solve together.

#include "bench/subjects.hpp"
#include "maille/fem_ref/ranks.hpp"
#include "maille/scene/world/trajectory.hpp"
#include "picture/world_picture.hpp"
#include "play/play.hpp"
#include "support/worlds/loops_of_1995.hpp"
#include "verify/verification.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <map>
#include <thread>

#include <unistd.h>

namespace maille::lab {
namespace {

volatile std::sig_atomic_t is_stopped = 0;

struct Request {
  std::string subject;
  bool quick = false, ranks = false;
  std::vector<std::string> only;
  int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
};

Request request_of(const std::vector<std::string>& words) {
  Request request;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const auto value = [&] { return i + 1 < words.size() ? words[++i] : std::string(); };
    if (words[i] == "--quick")
      request.quick = true;
    else if (words[i] == "--ranks")
      request.ranks = true;
    else if (words[i] == "--only")
      request.only.push_back(value());
    else if (words[i] == "--threads")
      request.threads = std::stoi(value());
    else
      request.subject = words[i];
  }
  return request;
}

/// Interrupts stop a subject between two rows, which are then printed.
Control control_of(const Request& request) {
  std::signal(SIGINT, [](int) { is_stopped = 1; });
  std::signal(SIGTERM, [](int) { is_stopped = 1; });
  Control control;
  control.threads = request.threads;
  control.stop_requested = [] { return is_stopped != 0; };
  if (isatty(STDERR_FILENO) == 1)
    control.progress = [](double fraction, std::string_view what) {
      fmt::print(stderr, "\r\033[K{:3.0f} %  {}", 100 * fraction, what);
    };
  return control;
}

using Bench = BenchReport (*)(const BenchOptions&, const Control&);

/// One that stops between two rows.
template<void (*bench)(const BenchOptions&, BenchReport&)>
BenchReport row_by_row(const BenchOptions& options, const Control& control) {
  BenchReport report;
  report.control = control;
  try {
    bench(options, report);
  } catch (const BenchStopped&) {
    report.checks.clear();
    report.notes.emplace_back("stopped: rows that were measured by then, and no checks");
  }
  return report;
}

const std::map<std::string, Bench, std::less<>> benches{
    {"propagate", row_by_row<bench_propagate>}, {"springs", row_by_row<bench_springs>},
    {"world", row_by_row<bench_world>},         {"live", row_by_row<bench_live>},
    {"warp", row_by_row<bench_warp>},           {"render", row_by_row<bench_render>}};

BenchReport verified(const Request& request, const Control& control) {
  VerificationOptions options;
  options.quick = request.quick;
  options.progress = control.progress;
  const std::vector<VerificationRow> rows = verify(options);
  const auto of_ranks = difference_of_two_ranks(std::filesystem::read_symlink("/proc/self/exe"));
  return verification_report(rows, worst_difference_from_calculix(), of_ranks);
}

int print_difference_of_ranks() {
  fem_ref::start_ranks();
  const double difference = worst_difference_between_ranks();
  if (fem_ref::ranks().is_first())
    fmt::print("{}\n", difference);
  return 0;
}

/// Names, one a line, that --only takes for a subject; without a subject, the subjects.
int print_names(const std::string& subject) {
  std::vector<std::string> names;
  if (subject == "world")
    names = world_bench_parts();
  else if (subject.empty()) {
    names = {"verify"};
    for (const auto& [name, bench] : benches)
      names.push_back(name);
  }
  for (const std::string& name : names)
    fmt::print("{}\n", name);
  return 0;
}

/// Plays a world by a loop of 1995, a picture a frame. @param words  --loop, and four
int play_loop(const std::vector<std::string>& words) {
  const WorldScene world = read_world_scene(words[2]);
  studies::Player player(test::world_of_1995(words[1], world), read_trajectory(words[3], world));
  for (int frame = 0;; ++frame, player.next()) {
    const std::string png = fmt::format("{}_{:03}.png", words[4], frame);
    if (const auto why_not = studies::render_world(world, {{words[1], &player.moment()}}, png))
      throw std::runtime_error(*why_not);
    if (player.is_at_end())
      return 0;
  }
}

int run(const std::vector<std::string>& words) {
  if (!words.empty() && words[0] == "--names")
    return print_names(words.size() > 1 ? words[1] : "");
  if (words.size() > 2 && words[0] == "--promises") {
    const auto row = promises_of(words[1], words[2], words.size() > 3 ? words[3] : "", {});
    fmt::print("{}\n", row.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
    return 0;
  }
  if (words.size() == 5 && words[0] == "--loop")
    return play_loop(words);
  const Request request = request_of(words);
  if (request.ranks)
    return print_difference_of_ranks();
  const Control control = control_of(request);
  BenchReport report;
  if (request.subject == "verify")
    report = verified(request, control);
  else
    report = benches.at(request.subject)(
        {.quick = request.quick, .only = request.only.empty() ? "" : request.only[0]}, control);
  if (control.progress)
    fmt::print(stderr, "\r\033[K");
  fmt::print("{}\n", report.json().dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
  return control.should_stop() ? 1 : 0;
}

} // namespace
} // namespace maille::lab

int main(int argc, char** argv) {
  try {
    return maille::lab::run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    fmt::print(stderr, "maille-lab: {}\n", error.what());
    return 1;
  }
}
