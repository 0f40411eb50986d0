#include "lattice/field_memory.hpp"

#include "maille/scene/memory.hpp"

#include <cstdint>
#include <cstring>
#include <new>

#ifdef __linux__
#include <map>
#include <mutex>
#include <sys/mman.h>
#endif

namespace maille::deform {

namespace {

constexpr std::size_t cache_line = 64;

#ifdef __linux__

constexpr std::size_t rounded_up(std::size_t bytes, std::size_t unit) {
  return (bytes + unit - 1) / unit * unit;
}

/// What is mapped for a field: a last large page that it nearly fills is mapped as a whole.
std::size_t mapped_bytes(std::size_t bytes) {
  constexpr std::size_t page = 4096;
  return rounded_up(bytes, bytes % large_page >= least_mapped ? large_page : page);
}

/// Large pages that fields share. No memory is given out twice, so all of it is zeros; a page goes back to
/// the system with the last of its fields.
class SharedPages {
public:
  void* take(std::size_t bytes) {
    const std::size_t size = rounded_up(bytes, cache_line);
    const std::lock_guard lock(mutex_);
    Page*& page = with_room_[Arena::open_on_this_thread()];
    if (page == nullptr || page->used + size > large_page) {
      Charge charge(large_page);
      page = new (map_aligned(large_page, large_page)) Page{std::move(charge), Arena::open_on_this_thread()};
    }
    void* const memory = reinterpret_cast<char*>(page) + page->used;
    page->used += size;
    ++page->arrays;
    return memory;
  }
  void give_back(void* memory) noexcept {
    const std::lock_guard lock(mutex_);
    char* const at = static_cast<char*>(memory);
    Page* const page = reinterpret_cast<Page*>(at - reinterpret_cast<std::uintptr_t>(at) % large_page);
    if (--page->arrays > 0)
      return;
    if (const auto last = with_room_.find(page->arena); last != with_room_.end() && last->second == page)
      with_room_.erase(last);
    page->~Page();
    munmap(page, large_page);
  }
  /// Never destroyed, because static destructors may still destroy fields.
  static SharedPages& all() {
    static SharedPages* const pages = new SharedPages;
    return *pages;
  }

private:
  /// At the beginning of each.
  struct alignas(cache_line) Page {
    Charge charge;
    Arena::Ledger* arena; ///< none other has the same address while it is charged
    std::size_t used = sizeof(Page), arrays = 0;
  };
  std::mutex mutex_;
  std::map<Arena::Ledger*, Page*> with_room_; ///< the last page of an arena
};

#endif

/// Zeros of the system's own pages from `least` bytes on, else written into memory for arrays.
void* zeroed(std::size_t bytes, [[maybe_unused]] std::size_t least, Charge& charge) {
#ifdef __linux__
  if (bytes >= least) {
    charge = Charge(mapped_bytes(bytes));
    return map_aligned(mapped_bytes(bytes), large_page);
  }
#endif
  charge = Charge(bytes);
  return std::memset(allocate_array(bytes, cache_line), 0, bytes);
}

void release(void* memory, std::size_t bytes, [[maybe_unused]] std::size_t least) noexcept {
#ifdef __linux__
  if (bytes >= least) {
    munmap(memory, mapped_bytes(bytes));
    return;
  }
#endif
  release_array(memory, bytes, cache_line);
}

} // namespace

void* allocate_field(std::size_t bytes, Charge& charge) {
#ifdef __linux__
  if (bytes >= least_shared && bytes < least_mapped)
    return SharedPages::all().take(bytes);
#endif
  return zeroed(bytes, least_mapped, charge);
}

void release_field(void* memory, std::size_t bytes) noexcept {
  if (memory == nullptr)
    return;
#ifdef __linux__
  if (bytes >= least_shared && bytes < least_mapped) {
    SharedPages::all().give_back(memory);
    return;
  }
#endif
  release(memory, bytes, least_mapped);
}

void* allocate_zeroed(std::size_t bytes, Charge& charge) {
  return zeroed(bytes, large_page, charge);
}

void release_zeroed(void* memory, std::size_t bytes) noexcept {
  if (memory != nullptr)
    release(memory, bytes, large_page);
}

} // namespace maille::deform
