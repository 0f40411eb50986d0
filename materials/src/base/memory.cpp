#include "maille/base/arena.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif
#include <sys/resource.h>
#include <unistd.h>

namespace maille {

namespace {

constexpr std::int64_t no_limit = std::numeric_limits<std::int64_t>::max();

/// A line such as `MemAvailable:   123 kB` of a /proc file [bytes]; -1 without that line.
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

/// Remaining bytes of a resource within the limit of the process; a very large number without a limit.
std::int64_t left_of(decltype(RLIMIT_AS) resource, const std::string& used_key) {
  rlimit limit{};
  if (getrlimit(resource, &limit) != 0 || limit.rlim_cur >= static_cast<rlim_t>(no_limit))
    return no_limit;
  const std::int64_t used = std::max<std::int64_t>(0, kilobytes_line("/proc/self/status", used_key));
  return std::max<std::int64_t>(0, static_cast<std::int64_t>(limit.rlim_cur) - used);
}

} // namespace

std::int64_t available_memory() {
  std::int64_t available = kilobytes_line("/proc/meminfo", "MemAvailable:");
  if (available < 0)
    available = std::int64_t{sysconf(_SC_PHYS_PAGES)} * sysconf(_SC_PAGESIZE);
  return std::min(
      {available, left_in_control_groups(), left_of(RLIMIT_AS, "VmSize:"), left_of(RLIMIT_DATA, "VmData:")});
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
