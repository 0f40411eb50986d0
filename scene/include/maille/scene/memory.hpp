#pragma once
/// How much memory the process can still have, and how large arrays are requested.
///
/// available_memory() is the least of three limits: the machine, the control groups, ulimit. Methods compare
/// it with their forecast and refuse before they allocate. Large arrays ask for large pages, which are a
/// wish: results do not depend on it.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

namespace maille {

/// Memory that this process could have now without swapping [bytes]: the least of the system's available
/// memory, the rest of its control groups (a container, a batch job), and its own limits (ulimit -v, -d).
std::int64_t available_memory();

/// What the memory limits of this process' control group and of those around it leave [bytes], of both
/// versions; files that are only cached count as free. A very large number where there is no limit.
/// @param root  where `proc/self/cgroup` and `sys/fs/cgroup` are looked for
std::int64_t left_in_control_groups(const std::filesystem::path& root = "/");

/// A count of bytes for people, in the unit that leaves three digits or less before the point: `384 bytes`,
/// `1.5 KiB`, `130 MiB`, `5.2 GiB`.
std::string bytes_in_words(double bytes);

/// Asks the system to bring memory that is not touched yet in large pages, where there is much of it: that
/// takes a tenth of the time, and fewer are looked up. A wish, which it may decline. What lies beside it in
/// the same pages is the allocator's too, so the wish does no harm there.
void ask_for_large_pages(void* begin, std::size_t bytes);

#ifdef __linux__
/// Zeroed memory of the system's own, in large pages if it grants them, from a multiple of `alignment` on.
/// @param size of whole pages [bytes] @param alignment a multiple of the page's @throws std::bad_alloc
void* map_aligned(std::size_t size, std::size_t alignment);
#endif

/// A vector's resize() in large pages.
template<class Values>
void resize_in_large_pages(Values& values, std::size_t n, typename Values::value_type value = {}) {
  values.reserve(n);
  if (n > values.size())
    ask_for_large_pages(values.data() + values.size(), (n - values.size()) * sizeof value);
  values.resize(n, value);
}

} // namespace maille
