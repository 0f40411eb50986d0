#include "lattice/field_memory.hpp"

#include "maille/base/arena.hpp"

#include <cstring>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace maille::deform {

namespace {

constexpr std::size_t cache_line = 64, page = 4096, large_page = std::size_t{2} << 20;
/// Arrays from here on are mapped: a last large page that one nearly fills is mapped as a whole.
constexpr std::size_t least_mapped = large_page / 4 * 3;

bool is_mapped([[maybe_unused]] std::size_t bytes) {
#ifdef __linux__
  return bytes >= least_mapped;
#else
  return false;
#endif
}

/// What is mapped, or asked for as an array.
std::size_t whole(std::size_t bytes) {
  const std::size_t unit = bytes % large_page >= least_mapped ? large_page : page;
  return is_mapped(bytes) ? (bytes + unit - 1) / unit * unit : bytes;
}

} // namespace

void* allocate_zeroed(std::size_t bytes, Charge& charge) {
  charge = Charge(whole(bytes));
#ifdef __linux__
  if (is_mapped(bytes))
    return map_aligned(whole(bytes), large_page);
#endif
  return std::memset(allocate_array(bytes, cache_line), 0, bytes);
}

void release_zeroed(void* memory, std::size_t bytes) noexcept {
  if (memory == nullptr)
    return;
#ifdef __linux__
  if (is_mapped(bytes)) {
    munmap(memory, whole(bytes));
    return;
  }
#endif
  release_array(memory, bytes, cache_line);
}

} // namespace maille::deform
