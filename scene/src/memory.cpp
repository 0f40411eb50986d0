#include "maille/scene/memory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <string>

#include <sys/resource.h>
#include <unistd.h>

namespace maille {

namespace {

/// A line such as `MemAvailable:   123 kB` of a /proc file [bytes]; -1 where there is none.
std::int64_t kilobytes_line(const char* file, const std::string& key) {
  std::ifstream stream(file);
  for (std::string word; stream >> word;)
    if (word == key) {
      std::int64_t kilobytes = 0;
      stream >> kilobytes;
      return kilobytes * 1024;
    }
  return -1;
}

/// What the control group leaves; a very large number where it sets no limit ("max").
std::int64_t left_in_the_control_group() {
  std::ifstream limit_file("/sys/fs/cgroup/memory.max"), used_file("/sys/fs/cgroup/memory.current");
  std::int64_t limit = 0, used = 0;
  if (limit_file >> limit && used_file >> used)
    return std::max<std::int64_t>(0, limit - used);
  return std::numeric_limits<std::int64_t>::max();
}

} // namespace

std::int64_t available_memory() {
  std::int64_t available = kilobytes_line("/proc/meminfo", "MemAvailable:");
  if (available < 0)
    available = std::int64_t{sysconf(_SC_PHYS_PAGES)} * sysconf(_SC_PAGESIZE);
  available = std::min(available, left_in_the_control_group());
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) {
    const std::int64_t used = std::max<std::int64_t>(0, kilobytes_line("/proc/self/status", "VmSize:"));
    const auto most = static_cast<std::int64_t>(
        std::min<rlim_t>(limit.rlim_cur, static_cast<rlim_t>(std::numeric_limits<std::int64_t>::max())));
    available = std::min(available, std::max<std::int64_t>(0, most - used));
  }
  return available;
}

std::string bytes_in_words(double bytes) {
  constexpr double step = 1024, carries = 999.5; // what is rounded to three digits must not become 1e+03
  if (bytes < carries)
    return fmt::format("{:.0f} byte{}", bytes, std::round(bytes) == 1 ? "" : "s");
  constexpr std::array units{"KiB", "MiB", "GiB", "TiB"};
  std::size_t unit = 0;
  for (bytes /= step; bytes >= carries && unit + 1 < units.size(); bytes /= step)
    ++unit;
  return bytes < carries ? fmt::format("{:.3g} {}", bytes, units[unit])
                         : fmt::format("{:.0f} {}", bytes, units[unit]);
}

} // namespace maille
