#include "memory.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fstream>
#include <limits>

namespace maille::fem_ref {
namespace {

constexpr std::int64_t unlimited = std::numeric_limits<std::int64_t>::max();

std::int64_t available_on_the_machine() {
  std::ifstream file("/proc/meminfo");
  std::string key, rest;
  std::int64_t kibibytes = 0;
  while (file >> key >> kibibytes) {
    if (key == "MemAvailable:")
      return 1024 * kibibytes;
    std::getline(file, rest);
  }
  return unlimited;
}

std::int64_t left_in_the_control_group() {
  std::ifstream limit_file("/sys/fs/cgroup/memory.max"), used_file("/sys/fs/cgroup/memory.current");
  std::int64_t limit = 0, used = 0;
  if (limit_file >> limit && used_file >> used) // "max" is no number: no limit
    return std::max<std::int64_t>(0, limit - used);
  return unlimited;
}

} // namespace

std::int64_t available_bytes() {
  return std::min(available_on_the_machine(), left_in_the_control_group());
}

std::string bytes_in_words(double bytes) {
  return bytes < 1e9 ? fmt::format("{:.3g} MB", bytes / 1e6) : fmt::format("{:.3g} GB", bytes / 1e9);
}

} // namespace maille::fem_ref
