/// Memory that a process may still take: of the machine, its control groups (containers) and its limits;
/// and large pages.

#include "maille/base/arena.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <new>
#include <optional>
#include <string>

#ifdef __linux__
#include <sys/mman.h>
#endif
#include <sys/resource.h>
#include <unistd.h>

namespace maille {

namespace {

namespace fs = std::filesystem;

constexpr std::int64_t no_limit = std::numeric_limits<std::int64_t>::max();

/// The number after a word of a /proc file, such as `MemAvailable:   123 kB`; nothing without that word.
std::optional<std::int64_t> number_after(const fs::path& file, const std::string& key) {
  std::ifstream stream(file);
  std::int64_t number = 0;
  for (std::string word; stream >> word;)
    if (word == key && stream >> number)
      return number;
  return std::nullopt;
}

/// Remaining bytes of a resource within the limit of the process; a very large number without a limit.
std::int64_t left_of(decltype(RLIMIT_AS) resource, const std::string& used_key) {
  rlimit limit{};
  if (getrlimit(resource, &limit) != 0 || limit.rlim_cur >= static_cast<rlim_t>(no_limit))
    return no_limit;
  const std::int64_t used = 1024 * number_after("/proc/self/status", used_key).value_or(0);
  return std::max<std::int64_t>(0, static_cast<std::int64_t>(limit.rlim_cur) - used);
}

/// File names of one version.
struct Files {
  const char *limit, *used, *statistics, *cached;
};
constexpr Files of_version_1{"memory.limit_in_bytes", "memory.usage_in_bytes", "memory.stat",
                             "total_inactive_file"};
constexpr Files of_version_2{"memory.max", "memory.current", "memory.stat", "inactive_file"};

/// No limit: "max", or nearly the largest number in version 1.
std::int64_t left_in(const fs::path& group, const Files& files) {
  std::ifstream limit_file(group / files.limit), used_file(group / files.used);
  std::int64_t limit = 0, used = 0;
  if (!(limit_file >> limit && used_file >> used) || limit > no_limit / 4)
    return no_limit;
  // The system drops cached files before it refuses memory.
  used -= std::min(used, number_after(group / files.statistics, files.cached).value_or(0));
  return std::max<std::int64_t>(0, limit - used);
}

/// Minimum remaining memory over a group and its parents. Skips those that a container hides.
std::int64_t left_below(const fs::path& mounted, std::string group, const Files& files) {
  std::int64_t left = left_in(mounted, files);
  for (; group.size() > 1; group.resize(group.find_last_of('/')))
    left = std::min(left, left_in(mounted / group.substr(1), files));
  return left;
}

bool names_memory(const std::string& controllers) {
  return ("," + controllers + ",").find(",memory,") != std::string::npos;
}

} // namespace

std::int64_t left_in_control_groups(const fs::path& root) {
  const fs::path mounted = root / "sys/fs/cgroup";
  std::int64_t left = no_limit;
  std::ifstream groups(root / "proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) { // number:controllers:/group
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos || line.compare(second + 1, 1, "/") != 0)
      continue;
    const std::string controllers = line.substr(first + 1, second - first - 1),
                      group = line.substr(second + 1);
    if (controllers.empty()) // version 2; if both are in use, in its own folder
      left = std::min({left, left_below(mounted, group, of_version_2),
                       left_below(mounted / "unified", group, of_version_2)});
    else if (names_memory(controllers))
      left = std::min(left, left_below(mounted / "memory", group, of_version_1));
  }
  return left;
}

std::int64_t available_memory() {
  const auto kilobytes = number_after("/proc/meminfo", "MemAvailable:");
  return std::min(
      {kilobytes ? 1024 * *kilobytes : std::int64_t{sysconf(_SC_PHYS_PAGES)} * sysconf(_SC_PAGESIZE),
       left_in_control_groups(), left_of(RLIMIT_AS, "VmSize:"), left_of(RLIMIT_DATA, "VmData:")});
}

std::string bytes_in_words(double bytes) {
  constexpr double step = 1024, carries = 999.5; // rounding to three digits must not give 1e+03
  if (bytes < carries)
    return fmt::format("{:.0f} byte{}", bytes, std::round(bytes) == 1 ? "" : "s");
  constexpr std::array units{"KiB", "MiB", "GiB", "TiB"};
  std::size_t unit = 0;
  for (bytes /= step; bytes >= carries && unit + 1 < units.size(); bytes /= step)
    ++unit;
  return bytes < carries ? fmt::format("{:.3g} {}", bytes, units[unit])
                         : fmt::format("{:.0f} {}", bytes, units[unit]);
}

void ask_for_large_pages([[maybe_unused]] void* begin, [[maybe_unused]] std::size_t bytes) {
#ifdef __linux__
  constexpr std::size_t much = std::size_t{1} << 20;
  if (bytes < much)
    return;
  constexpr std::uintptr_t page = 4096;
  const auto first = reinterpret_cast<std::uintptr_t>(begin) / page * page,
             last = (reinterpret_cast<std::uintptr_t>(begin) + bytes) / page * page;
  madvise(reinterpret_cast<void*>(first), last - first, MADV_HUGEPAGE);
#endif
}

#ifdef __linux__
void* map_aligned(std::size_t size, std::size_t alignment) {
  void* const mapped =
      mmap(nullptr, size + alignment, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (mapped == MAP_FAILED)
    throw std::bad_alloc();
  char* const begin = static_cast<char*>(mapped);
  const std::size_t before = (alignment - reinterpret_cast<std::uintptr_t>(begin) % alignment) % alignment;
  char* const memory = begin + before;
  if (before > 0)
    munmap(begin, before);
  if (alignment > before)
    munmap(memory + size, alignment - before);
  ask_for_large_pages(memory, size);
  return memory;
}
#endif

} // namespace maille
