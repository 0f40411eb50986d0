/// What memory limits leave, read from folders that look like the kernel's. The numbers are those written
/// into them.

#include "maille/scene/memory.hpp"
#include "support/sanitized.hpp"

#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <limits>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace maille {
namespace {

/// A root folder of a test's own, with whatever folders its files need.
class Root : public test::TemporaryFolder {
public:
  void write(const std::string& name, std::string_view content) const {
    std::filesystem::create_directories((path() / name).parent_path());
    test::TemporaryFolder::write(name, content);
  }
};

constexpr std::int64_t nothing_limits = std::numeric_limits<std::int64_t>::max();

TEST(ControlGroupsContract, TheLeastOfAllGroupsAroundTheProcessCounts) {
  const Root root;
  EXPECT_EQ(left_in_control_groups(root.path()), nothing_limits) << "no control groups at all";
  root.write("proc/self/cgroup", "0::/system.slice/slurm/job_7/step_0\n");
  const std::string groups = "sys/fs/cgroup/";
  root.write(groups + "system.slice/slurm/job_7/step_0/memory.max", "max\n");
  root.write(groups + "system.slice/slurm/job_7/step_0/memory.current", "100\n");
  EXPECT_EQ(left_in_control_groups(root.path()), nothing_limits) << "max is no limit";
  root.write(groups + "system.slice/memory.max", "9000\n");
  root.write(groups + "system.slice/memory.current", "1000\n");
  EXPECT_EQ(left_in_control_groups(root.path()), 8000) << "of a group far above";
  root.write(groups + "system.slice/slurm/job_7/memory.max", "700\n");
  root.write(groups + "system.slice/slurm/job_7/memory.current", "300\n");
  EXPECT_EQ(left_in_control_groups(root.path()), 400) << "of the job";
  root.write(groups + "system.slice/slurm/job_7/memory.stat", "anon 120\ninactive_file 150\nslab 3\n");
  EXPECT_EQ(left_in_control_groups(root.path()), 550) << "files that are only cached are given up";
  root.write(groups + "system.slice/slurm/job_7/memory.current", "5000\n");
  EXPECT_EQ(left_in_control_groups(root.path()), 0) << "more in use than is allowed";
  root.write(groups + "system.slice/other/memory.max", "1\n");
  root.write(groups + "system.slice/slurm/job_7/memory.current", "300\n");
  EXPECT_EQ(left_in_control_groups(root.path()), 550) << "another's group";
}

TEST(ControlGroupsContract, ContainersThatShowTheirOwnGroupAsTheRoot) {
  const Root root;
  root.write("proc/self/cgroup", "0::/docker/0123456789abcdef\n");
  root.write("sys/fs/cgroup/memory.max", "5000\n");
  root.write("sys/fs/cgroup/memory.current", "2000\n");
  EXPECT_EQ(left_in_control_groups(root.path()), 3000);
}

TEST(ControlGroupsContract, VersionOneIsReadToo) {
  const Root root;
  root.write("proc/self/cgroup", "12:cpu,cpuacct:/user\n9:hugetlb,memory:/slurm/job_7\n1:name=systemd:/\n");
  const std::string groups = "sys/fs/cgroup/memory/";
  root.write(groups + "memory.limit_in_bytes", "9223372036854771712\n");
  root.write(groups + "memory.usage_in_bytes", "123456\n");
  EXPECT_EQ(left_in_control_groups(root.path()), nothing_limits)
      << "the largest multiple of a page is no limit";
  root.write(groups + "slurm/memory.limit_in_bytes", "600\n");
  root.write(groups + "slurm/memory.usage_in_bytes", "50\n");
  root.write(groups + "slurm/memory.stat", "inactive_file 1\ntotal_inactive_file 20\n");
  EXPECT_EQ(left_in_control_groups(root.path()), 570);
  // Both versions at once, as between the two.
  root.write("proc/self/cgroup", "0::/user\n9:memory:/slurm\n");
  root.write("sys/fs/cgroup/unified/user/memory.max", "100\n");
  root.write("sys/fs/cgroup/unified/user/memory.current", "10\n");
  EXPECT_EQ(left_in_control_groups(root.path()), 90);
}

TEST(ControlGroupsContract, DamagedFilesLimitNothing) {
  const Root root;
  root.write("proc/self/cgroup", "\n::\n0\n0:\n0::\n0::x\n4:memory\n0::/a\n");
  root.write("sys/fs/cgroup/a/memory.max", "much\n");
  root.write("sys/fs/cgroup/a/memory.current", "-\n");
  EXPECT_EQ(left_in_control_groups(root.path()), nothing_limits);
}

// In a process of its own: a limit cannot be taken back.
TEST(MemoryLimitsContract, LimitsOfAddressSpaceAndOfDataCount) {
#ifdef MAILLE_CHECKS_ACCESS
  GTEST_SKIP() << "the address sanitizer has taken terabytes of addresses before";
#endif
  constexpr std::int64_t some = std::int64_t{1} << 28; // 256 MiB
  for (const auto resource : {RLIMIT_AS, RLIMIT_DATA}) {
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      const rlimit limit{static_cast<rlim_t>(some), static_cast<rlim_t>(some)};
      const bool is_set = setrlimit(resource, &limit) == 0;
      const std::int64_t left = available_memory();
      _exit(is_set && left >= 0 && left < some ? 0 : 1);
    }
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << (resource == RLIMIT_AS ? "-v" : "-d");
  }
}

} // namespace
} // namespace maille
