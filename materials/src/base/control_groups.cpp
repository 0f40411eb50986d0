#include "maille/base/arena.hpp"

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>

namespace maille {
namespace {
namespace fs = std::filesystem;

constexpr std::int64_t no_limit = std::numeric_limits<std::int64_t>::max();

/// File names of one version.
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

/// No limit: "max", or nearly the largest number in version 1.
std::int64_t left_in(const fs::path& group, const Files& files) {
  std::ifstream limit_file(group / files.limit), used_file(group / files.used);
  std::int64_t limit = 0, used = 0;
  if (!(limit_file >> limit && used_file >> used) || limit > no_limit / 4)
    return no_limit;
  // The system drops cached files before it refuses memory.
  used -= std::min(used, statistic(group / files.statistics, files.cached));
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

} // namespace maille
