#pragma once
/// What a benchmark found: the machine, rows of measurements, and the figures that goals.toml has goals for.

#include "maille/scene/answer.hpp"

#include <nlohmann/json.hpp>

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace maille::studies {}
namespace maille::lab {

using namespace studies;

struct BenchOptions {
  bool quick = false; ///< small bodies and few repeats: the same path in seconds, figures that mean nothing
  std::string only;   ///< of `world`: one part (world_bench_parts); empty: all
};

/// One figure that is aimed for; its goal stands in studies/lab/goals.toml.
struct BenchCheck {
  std::string name;
  double value = 0;
  std::string predicted{}, physical_limit{}; ///< in words; empty if unknown
  std::optional<double> goal{};              ///< of checks whose goal is what an opponent reached in this run
};

/// Thrown where a benchmark is asked to stop: it ends with the rows it has, and without checks.
struct BenchStopped {};

/// `{"machine":{...,"copy_gb_per_s"},"rows":[...],"notes":[...],"checks":[{"name","value"}]}`;
/// checks that have them also carry "predicted", "physical_limit" and "goal".
struct BenchReport {
  Control control; ///< how the caller steers what is measured
  nlohmann::ordered_json machine;
  std::vector<nlohmann::ordered_json> rows; ///< flat objects: text and numbers
  std::vector<std::string> notes;           ///< what was left out, and what figures mean
  std::vector<BenchCheck> checks;

  /// Adds a row, and says that it is there. @throws BenchStopped if the caller asked to stop
  void add(nlohmann::ordered_json row);
  /// What is measured on one thread, and stops when the caller asks.
  Control one_thread() const;
  nlohmann::ordered_json json() const;
};

/// Processor, cores, memory, compiler, and the load average at the start, which shows other work.
nlohmann::ordered_json describe_machine();

/// Bytes read plus bytes written per second of copying an array of `bytes` to another, in GB/s: the best of a
/// plain and a streaming (non-temporal) copy, each by the median over `repeats`, with `threads` threads.
double copy_bandwidth(std::size_t bytes, int repeats, int threads);

/// Median of the wall-clock seconds of `work` over `repeats` runs after one that is not counted; `prepare`
/// runs before each and is not timed.
double median_seconds(int repeats, const std::function<void()>& prepare, const std::function<void()>& work);

} // namespace maille::lab
