#include "maille/studies/bench_report.hpp"

#include "maille/studies/version.hpp"
#include "median.hpp"
#include "results/checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <span>
#include <thread>
#include <utility>

namespace maille::studies {

namespace {

std::string first_value(const char* file, const std::string& key) {
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);)
    if (line.starts_with(key))
      return line.substr(std::min(line.size(), line.find(':') + 2));
  return "unknown";
}

/// Keys of an object in their order, to tell which rows belong into one table.
std::vector<std::string> keys_of(const nlohmann::ordered_json& row) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : row.items())
    keys.push_back(key);
  return keys;
}

/// Of rows that all have the same keys.
std::string one_table(std::span<const Value> rows) {
  ResultTable<Value> columns;
  for (const std::string& key : keys_of(rows.front()))
    columns.add({"", key, "", ""}, {key}, [key](const Value& row) { return row.at(key); });
  return columns.text(rows) + "\n";
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
  return {{"machine", machine},
          {"rows", rows},
          {"notes", notes},
          {"checks", columns_of_checks().json_rows(checks)}};
}

std::string BenchReport::table() const {
  std::string text;
  for (const auto& [key, value] : machine.items())
    text += fmt::format("{:<16} {}\n", key,
                        value.is_number_float() ? fmt::format("{:.4g}", value.get<double>())
                        : value.is_string()     ? value.get<std::string>()
                                                : value.dump());
  text += "\n";
  for (std::size_t first = 0; first < rows.size();) {
    std::size_t last = first + 1;
    while (last < rows.size() && keys_of(rows[last]) == keys_of(rows[first]))
      ++last;
    text += one_table(std::span(rows).subspan(first, last - first));
    first = last;
  }
  for (const std::string& note : notes)
    text += note + "\n";
  text += notes.empty() ? "" : "\n";
  for (const BenchCheck& check : checks) {
    text += fmt::format("{:<5}{:<36}{:>12.4g}  ({} {:g})\n", check.met() ? "met" : "MISS", check.name,
                        check.value, check.larger_is_better ? "at least" : "at most", check.goal);
    if (!check.predicted.empty())
      text += fmt::format("     predicted: {}\n", check.predicted);
    if (!check.physical_limit.empty())
      text += fmt::format("     limit: {}\n", check.physical_limit);
  }
  return text;
}

bool has_data(std::string_view file) {
  const char* const data = std::getenv("MAILLE_DATA");
  return data != nullptr && std::filesystem::exists(std::filesystem::path(data) / file);
}

bool BenchReport::all_met() const {
  return std::all_of(checks.begin(), checks.end(), [](const BenchCheck& check) { return check.met(); });
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

} // namespace maille::studies
