#include "memory.hpp"

#include <algorithm>
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

} // namespace

std::int64_t available_memory() {
  std::int64_t available = kilobytes_line("/proc/meminfo", "MemAvailable:");
  if (available < 0)
    available = std::int64_t{sysconf(_SC_PHYS_PAGES)} * sysconf(_SC_PAGESIZE);
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) {
    const std::int64_t used = std::max<std::int64_t>(0, kilobytes_line("/proc/self/status", "VmSize:"));
    const auto most = static_cast<std::int64_t>(
        std::min<rlim_t>(limit.rlim_cur, static_cast<rlim_t>(std::numeric_limits<std::int64_t>::max())));
    available = std::min(available, std::max<std::int64_t>(0, most - used));
  }
  return available;
}

} // namespace maille
