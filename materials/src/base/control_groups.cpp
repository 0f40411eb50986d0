#include "maille/base/arena.hpp"

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>

namespace maille {
namespace {
namespace fs = std::filesystem;

constexpr std::int64_t no_limit = std::numeric_limits<std::int64_t>::max();

/// The names of one version's files.
struct Files {
  const char *limit, *used, *statistics, *cached;
};
constexpr Files of_version_1{"memory.limit_in_bytes", "memory.usage_in_bytes", "memory.stat",
                             "total_inactive_file"};
constexpr Files of_version_2{"memory.max", "memory.current", "memory.stat", "inactive_file"};

/// The value of a key, or 0.
std::int64_t statistic(const fs::path& file, const std::string& key) {
  std::ifstream stream(file);
  std::int64_t value = 0;
  for (std::string word; stream >> word >> value;)
    if (word == key)
      return value;
  return 0;
}

/// "max", and what version 1 says for it, all but the largest number, are no limits.
std::int64_t left_in(const fs::path& group, const Files& files) {
  std::ifstream limit_file(group / files.limit), used_file(group / files.used);
  std::int64_t limit = 0, used = 0;
  if (!(limit_file >> limit && used_file >> used) || limit > no_limit / 4)
    return no_limit;
  // The system gives up files that it only caches before it refuses memory.
  used -= std::min(used, statistic(group / files.statistics, files.cached));
  return std::max<std::int64_t>(0, limit - used);
}

/// Least memory left by a group and its parents. Those that a container does not show are skipped.
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
    if (controllers.empty()) // version 2; where both are in use, in a folder of its own
      left = std::min({left, left_below(mounted, group, of_version_2),
                       left_below(mounted / "unified", group, of_version_2)});
    else if (names_memory(controllers))
      left = std::min(left, left_below(mounted / "memory", group, of_version_1));
  }
  return left;
}

} // namespace maille
