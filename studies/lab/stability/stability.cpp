#include "stability/stability.hpp"

#include "checks/promises.hpp"
#include "maille/materials/json.hpp"
#include "stability/columns.hpp"
#include "stability/extremes.hpp"
#include "stability/questions.hpp"
#include "study/worker_pool.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <limits>
#include <map>
#include <sys/resource.h>
#include <unistd.h>

namespace maille::lab {

namespace {

constexpr double seconds_budget = 10;     ///< that a method is asked to keep
constexpr unsigned seconds_of_work = 300; ///< of the processor; what goes on after that hangs
constexpr std::uint64_t scenes_a_task = 100, worlds_a_task = 20;

/// Ends this process where a task takes longer, in the processor's time, or ten times as long by the clock.
void start_watch() {
  std::signal(SIGALRM, SIG_DFL);
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  rlimit limit{};
  getrlimit(RLIMIT_CPU, &limit);
  limit.rlim_cur = static_cast<rlim_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec) + seconds_of_work;
  setrlimit(RLIMIT_CPU, &limit);
  alarm(10 * seconds_of_work);
}

/// In a process of its own.
StabilityCell ask(const Extreme& extreme, const std::string& method,
                  const std::function<bool()>& should_stop) {
  Control control;
  control.seconds_budget = seconds_budget;
  control.stop_requested = should_stop;
  Methods methods;
  StabilityCell cell;
  try {
    if (extreme.protocol) {
      control.seconds_budget.reset(); // of one step it would mean nothing
      return extreme.protocol(methods, method, control);
    }
    const Scene scene = extreme.scene();
    return judged(extreme, scene, method, methods.answer(scene, method, control));
  } catch (const InputError& error) {
    cell.outcome = "refused";
    cell.note = "by the reader: " + to_string(error.faults().at(0));
    cell.broken = extreme.must_be_refused || !extreme.is_normal ? "" : "the normal setting is refused";
  } catch (const std::exception& error) {
    cell.outcome = "threw";
    cell.broken = fmt::format("an exception came out: {}", error.what());
  }
  return cell;
}

struct Task {
  std::size_t extreme;
  std::string method;
};

std::vector<Task> tasks_of(const std::vector<Extreme>& extremes, const StabilityOptions& options) {
  std::vector<Task> tasks;
  for (std::size_t i = 0; i < extremes.size(); ++i)
    for (const std::string& method : extremes[i].methods.empty() ? stability_methods() : extremes[i].methods)
      if (!options.quick || method != "fem_q2")
        tasks.push_back({i, method});
  return tasks;
}

/// Iterations over those of the extreme's normal setting, where both ended by themselves.
void compare_with_normal(const std::vector<Extreme>& extremes, const std::vector<Task>& tasks,
                         std::vector<StabilityCell>& cells) {
  std::map<std::pair<std::string, std::string>, std::int64_t> normal;
  for (std::size_t i = 0; i < tasks.size(); ++i)
    if (extremes[tasks[i].extreme].is_normal)
      normal[{cells[i].extreme, cells[i].method}] = cells[i].iterations;
  for (StabilityCell& cell : cells)
    if (const auto place = normal.find({cell.extreme, cell.method});
        place != normal.end() && place->second > 0 && cell.violation)
      cell.over_normal = static_cast<double>(cell.iterations) / static_cast<double>(place->second);
}

void ask_extremes(const std::vector<Extreme>& extremes, const StabilityOptions& options,
                  const Control& control, Stability& result) {
  const std::vector<Task> tasks = tasks_of(extremes, options);
  std::vector<StabilityCell> cells(tasks.size());
  std::vector<bool> is_done(tasks.size(), false);
  std::size_t done = 0;
  const auto work = [&](std::size_t task, const std::function<bool()>& should_stop) {
    start_watch();
    const auto start = std::chrono::steady_clock::now();
    StabilityCell cell = ask(extremes[tasks[task].extreme], tasks[task].method, should_stop);
    cell.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return columns_of_stability().json(cell).dump(-1, ' ', false, Value::error_handler_t::replace);
  };
  const auto deliver = [&](const TaskResult& given) {
    StabilityCell& cell = cells[given.task];
    is_done[given.task] = true;
    const Extreme& extreme = extremes[tasks[given.task].extreme];
    if (given.death.empty()) {
      std::vector<Fault> faults; // none: it wrote what is read
      cell = columns_of_stability().read_json(parse_json(given.text, ""), "", 0, faults);
    } else {
      cell.outcome = "died";
      cell.broken = given.death;
    }
    cell.extreme = extreme.extreme;
    cell.setting = extreme.setting;
    cell.method = tasks[given.task].method;
    if (control.progress)
      control.progress(static_cast<double>(++done) / static_cast<double>(tasks.size()),
                       cell.extreme + ", " + cell.method);
  };
  work_through(tasks.size(), std::max(1, control.threads), work, deliver,
               [&] { return control.should_stop(); });
  compare_with_normal(extremes, tasks, cells);
  result.cells_asked = static_cast<std::int64_t>(tasks.size());
  for (std::size_t i = 0; i < tasks.size(); ++i)
    if (is_done[i])
      result.cells.push_back(std::move(cells[i]));
}

/// What is asked of seeds, and what comes of it.
struct RandomQuestions {
  std::string (*broken_promise)(std::uint64_t seed);
  const char* what;
  std::int64_t& n_asked;
  std::vector<std::string>& broken;
};

/// Asks `n` seeds from `first` on, in tasks of `a_task` seeds; if a process dies, each of its seeds alone.
void ask_random(const RandomQuestions& questions, std::uint64_t first, std::uint64_t n, std::uint64_t a_task,
                const Control& control) {
  std::vector<std::uint64_t> died;
  const auto seeds_of = [&](std::size_t task) {
    const std::uint64_t begin = first + task * a_task;
    return std::pair(begin, std::min(begin + a_task, first + n));
  };
  const auto work = [&](std::size_t task, const std::function<bool()>& should_stop) {
    start_watch();
    std::string text;
    const auto [begin, end] = seeds_of(task);
    for (std::uint64_t seed = begin; seed < end && !should_stop(); ++seed)
      if (const std::string broken = questions.broken_promise(seed); !broken.empty())
        text += broken + "\n";
    return text;
  };
  const auto deliver = [&](const TaskResult& given) {
    const auto [begin, end] = seeds_of(given.task);
    if (given.death.empty() || a_task == 1)
      questions.n_asked += static_cast<std::int64_t>(end - begin);
    if (!given.death.empty() && a_task > 1)
      died.push_back(begin);
    else if (!given.death.empty())
      questions.broken.push_back(fmt::format("seed {}: {}", begin, given.death));
    else if (!given.text.empty())
      for (std::size_t at = given.text.find("seed "); at != std::string::npos;) {
        const std::size_t next = given.text.find("\nseed ", at);
        questions.broken.push_back(given.text.substr(at, next - at));
        at = next == std::string::npos ? next : next + 1;
      }
    if (control.progress)
      control.progress(static_cast<double>(questions.n_asked) / static_cast<double>(n), questions.what);
  };
  const auto n_tasks = static_cast<std::size_t>((n + a_task - 1) / a_task);
  work_through(n_tasks, std::max(1, control.threads), work, deliver, [&] { return control.should_stop(); });
  for (const std::uint64_t begin : died)
    ask_random(questions, begin, std::min(a_task, first + n - begin), 1, control);
}

std::optional<double> worst_drift(const std::vector<StabilityCell>& cells, std::string_view method) {
  std::optional<double> worst;
  for (const StabilityCell& cell : cells)
    if (cell.extreme.starts_with("cyclic loading") && cell.method == method)
      worst = std::max(worst.value_or(0), cell.error.value_or(std::numeric_limits<double>::infinity()));
  return worst;
}

bool is_wanted(const StabilityOptions& options, const std::string& extreme) {
  return options.extremes.empty() || std::ranges::find(options.extremes, extreme) != options.extremes.end();
}

} // namespace

std::vector<std::string> stability_methods() {
  std::vector<std::string> names = all_methods();
  std::erase(names, "calculix");
  return names;
}

std::vector<Extreme> all_extremes(const ExtremeSizes& sizes) {
  std::vector<Extreme> list;
  add_extremes_of_limits(list);
  add_extremes_of_matter(list);
  add_extremes_of_shape(list, sizes);
  add_extremes_of_handles(list);
  add_extremes_of_turns(list);
  add_extremes_of_numbers(list);
  add_numbers_that_are_none(list);
  add_long_stories(list, sizes);
  add_extremes_of_worlds(list, sizes);
  add_extremes_of_crowds(list, sizes);
  return list;
}

std::vector<std::string> stability_extremes() {
  std::vector<std::string> names;
  for (const Extreme& extreme : all_extremes({}))
    if (names.empty() || names.back() != extreme.extreme)
      names.push_back(extreme.extreme);
  return names;
}

Stability stability(const StabilityOptions& options, const Control& control) {
  const ExtremeSizes sizes = options.quick ? ExtremeSizes{.long_body = 1000,
                                                          .drags = 50,
                                                          .cycles = 20,
                                                          .world_frames = 3,
                                                          .objects = 100,
                                                          .free_bodies = 9}
                                           : ExtremeSizes{};
  std::vector<Extreme> extremes = all_extremes(sizes);
  std::erase_if(extremes, [&](const Extreme& extreme) { return !is_wanted(options, extreme.extreme); });
  Stability result;
  result.is_quick = options.quick;
  ask_extremes(extremes, options, control, result);
  if (options.extremes.empty()) {
    if (!control.should_stop())
      ask_random({broken_promise_of_seed, "random scenes", result.random_scenes, result.broken_random_scenes},
                 1, options.quick ? 400 : 10000, scenes_a_task, control);
    if (!control.should_stop())
      ask_random(
          {broken_promise_of_world_seed, "random worlds", result.random_worlds, result.broken_random_worlds},
          1, options.quick ? 100 : 2000, worlds_a_task, control);
  }
  result.cyclic_drift_relaxed = worst_drift(result.cells, "relaxed");
  result.cyclic_drift_coupled = worst_drift(result.cells, "coupled");
  return result;
}

} // namespace maille::lab
