#pragma once
/// What the machine can still give, so that what cannot fit is refused before it is allocated.

#include <cstdint>
#include <filesystem>
#include <string>

namespace maille {

/// Memory that this process could have now without swapping [bytes]: what the system says is available, cut
/// to what its control groups (a container, a batch job) and its own limits (ulimit -v, -d) leave; the least
/// of them counts.
std::int64_t available_memory();

/// What the memory limits of this process' control group and of those around it leave [bytes], of both
/// versions; files that are only cached count as free. A very large number where there is no limit.
/// @param root  where `proc/self/cgroup` and `sys/fs/cgroup` are looked for
std::int64_t left_in_control_groups(const std::filesystem::path& root = "/");

/// A count of bytes for people, in the unit that leaves three digits or less before the point: `384 bytes`,
/// `1.5 KiB`, `130 MiB`, `5.2 GiB`.
std::string bytes_in_words(double bytes);

} // namespace maille
