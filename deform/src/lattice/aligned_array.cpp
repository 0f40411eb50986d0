#include "lattice/aligned_array.hpp"

#include <cstring>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace maille::deform {

namespace {

constexpr std::size_t cache_line = 64;
constexpr std::size_t large_page = std::size_t{2} << 20;

std::align_val_t alignment_of(std::size_t bytes) {
  return std::align_val_t{bytes >= large_page ? large_page : cache_line};
}

} // namespace

void* allocate_zeroed(std::size_t bytes) {
  void* memory = ::operator new(bytes, alignment_of(bytes));
#ifdef __linux__
  if (bytes >= large_page) // a wish; the system may decline it
    madvise(memory, bytes / large_page * large_page, MADV_HUGEPAGE);
#endif
  return std::memset(memory, 0, bytes);
}

void release_zeroed(void* memory, std::size_t bytes) noexcept {
  if (memory != nullptr)
    ::operator delete(memory, bytes, alignment_of(bytes));
}

} // namespace maille::deform
