// The functions that all of C and C++ allocate with, replaced for the whole program by ones that count and
// then call those of glibc.
#include "support/heap_meter.hpp"

#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdlib>

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define MAILLE_COUNTS_THE_HEAP 1
#include <malloc.h>
#else
#define MAILLE_COUNTS_THE_HEAP 0
#endif

namespace {

std::atomic<std::int64_t> live{0}, peak{0}, allocations{0};

#if MAILLE_COUNTS_THE_HEAP
void* counted(void* memory) {
  if (memory == nullptr)
    return nullptr;
  const auto size = static_cast<std::int64_t>(malloc_usable_size(memory));
  const std::int64_t now = live.fetch_add(size) + size;
  for (std::int64_t most = peak.load(); now > most && !peak.compare_exchange_weak(most, now);) {
  }
  ++allocations;
  return memory;
}

void uncount(void* memory) {
  if (memory != nullptr)
    live -= static_cast<std::int64_t>(malloc_usable_size(memory));
}
#endif

} // namespace

#if MAILLE_COUNTS_THE_HEAP
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

void* malloc(std::size_t size) {
  return counted(__libc_malloc(size));
}
void* calloc(std::size_t n, std::size_t size) {
  return counted(__libc_calloc(n, size));
}
void* realloc(void* memory, std::size_t size) {
  uncount(memory);
  void* const grown = __libc_realloc(memory, size);
  if (grown == nullptr && size > 0) // the old one is still there
    return counted(memory), nullptr;
  return counted(grown);
}
void* memalign(std::size_t alignment, std::size_t size) {
  return counted(__libc_memalign(alignment, size));
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  return counted(__libc_memalign(alignment, size));
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
  void* const found = __libc_memalign(alignment, size);
  if (found == nullptr)
    return ENOMEM;
  *memory = counted(found);
  return 0;
}
void free(void* memory) {
  uncount(memory);
  __libc_free(memory);
}
}
#endif

namespace maille::tests {

bool heap_is_counted() {
  return MAILLE_COUNTS_THE_HEAP != 0;
}

HeapMeter::HeapMeter() : live_before_(::live.load()), allocations_before_(::allocations.load()) {
  ::peak = live_before_;
}
std::int64_t HeapMeter::live() const {
  return ::live.load() - live_before_;
}
std::int64_t HeapMeter::peak() const {
  return ::peak.load() - live_before_;
}
std::int64_t HeapMeter::allocations() const {
  return ::allocations.load() - allocations_before_;
}

} // namespace maille::tests
