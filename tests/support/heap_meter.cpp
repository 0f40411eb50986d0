// The functions that all of C and C++ allocate with, and those that map memory, replaced for the whole
// program by ones that count and then call those of glibc or the system. What glibc itself maps for its heap
// and for stacks does not come by here.
#include "support/heap_meter.hpp"
#include "support/sanitized.hpp"

#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdlib>

#if defined(__GLIBC__) && !defined(MAILLE_CHECKS_ACCESS)
#define MAILLE_COUNTS_THE_HEAP 1
#include <malloc.h>
#include <mutex>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>
#else
#define MAILLE_COUNTS_THE_HEAP 0
#endif

namespace {

std::atomic<std::int64_t> live{0}, peak{0}, allocations{0};

/// Arrays that share pages cannot be told from those: they are the heap's in programs that are measured.
[[maybe_unused]] const int arrays_are_of_the_heap = setenv("MAILLE_ARRAYS", "heap", 1);

void note_peak() {
  const std::int64_t now = live.load();
  for (std::int64_t most = peak.load(); now > most && !peak.compare_exchange_weak(most, now);) {
  }
}

#if MAILLE_COUNTS_THE_HEAP
/// The last mapping, as far as it is still there. Who wants it aligned maps too much and returns what is over
/// at once: nothing holds that memory, so the peak is noted later.
struct Mapping {
  std::mutex mutex;
  std::uintptr_t begin = 0, end = 0;
} last;

void* counted(void* memory) {
  if (memory == nullptr)
    return nullptr;
  live += static_cast<std::int64_t>(malloc_usable_size(memory));
  note_peak();
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
void* mmap(void* at, std::size_t size, int access, int flags, int file, off_t offset) noexcept {
  note_peak();
  const long mapped = syscall(SYS_mmap, at, size, access, flags, file, offset);
  if (mapped != -1 && file == -1) {
    const std::lock_guard lock(last.mutex);
    last.begin = static_cast<std::uintptr_t>(mapped);
    last.end = last.begin + size;
    live += static_cast<std::int64_t>(size);
    ++allocations;
  }
  return reinterpret_cast<void*>(mapped);
}
int munmap(void* memory, std::size_t size) noexcept {
  const auto begin = reinterpret_cast<std::uintptr_t>(memory);
  {
    const std::lock_guard lock(last.mutex);
    if (begin == last.begin && size < last.end - last.begin)
      last.begin += size;
    else if (begin > last.begin && begin + size == last.end)
      last.end = begin;
    else
      note_peak();
  }
  live -= static_cast<std::int64_t>(size);
  return static_cast<int>(syscall(SYS_munmap, memory, size));
}
}
#endif

namespace maille::test {

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
  note_peak();
  return ::peak.load() - live_before_;
}
std::int64_t HeapMeter::allocations() const {
  return ::allocations.load() - allocations_before_;
}

} // namespace maille::test
