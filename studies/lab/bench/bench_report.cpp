#include "bench/bench_report.hpp"

#include "maille/studies/version.hpp"
#include "median.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <thread>
#include <utility>

namespace maille::lab {

namespace {

std::string first_value(const char* file, const std::string& key) {
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);)
    if (line.starts_with(key))
      return line.substr(std::min(line.size(), line.find(':') + 2));
  return "unknown";
}

} // namespace

void BenchReport::add(nlohmann::ordered_json row) {
  if (control.should_stop()) // what was measured last may have been cut short
    throw BenchStopped();
  rows.push_back(std::move(row));
  if (control.progress)
    control.progress(0, fmt::format("{} rows", rows.size()));
}

Control BenchReport::one_thread() const {
  Control one;
  one.stop_requested = control.stop_requested;
  return one;
}

nlohmann::ordered_json BenchReport::json() const {
  auto found = nlohmann::ordered_json::array();
  for (const BenchCheck& check : checks) {
    found.push_back({{"name", check.name}, {"value", check.value}});
    if (check.goal)
      found.back()["goal"] = *check.goal;
    for (const auto& [key, words] :
         {std::pair{"predicted", check.predicted}, std::pair{"physical_limit", check.physical_limit}})
      if (!words.empty())
        found.back()[key] = words;
  }
  return {{"machine", machine}, {"rows", rows}, {"notes", notes}, {"checks", found}};
}

nlohmann::ordered_json describe_machine() {
  std::ifstream load("/proc/loadavg");
  double busy = 0;
  load >> busy;
  return {{"maille", version},
          {"processor", first_value("/proc/cpuinfo", "model name")},
          {"cores", std::thread::hardware_concurrency()},
          {"memory", first_value("/proc/meminfo", "MemTotal")},
          {"compiler", "g++ " __VERSION__},
          {"load_average", busy}};
}

double median_seconds(int repeats, const std::function<void()>& prepare, const std::function<void()>& work) {
  std::vector<double> seconds;
  for (int run = 0; run <= repeats; ++run) {
    prepare();
    const auto start = std::chrono::steady_clock::now();
    work();
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
    if (run > 0)
      seconds.push_back(wall.count());
  }
  return upper_median(std::move(seconds));
}

} // namespace maille::lab
