#include "maille/base/arena.hpp"

#include <atomic>
#include <cstdlib>
#include <iterator>
#include <map>
#include <mutex>
#include <pthread.h>
#include <string_view>

// Sanitizers need a separate allocation per array to detect writes beyond its end.
#if defined(__SANITIZE_ADDRESS__)
#define MAILLE_KEEPS_ARRAYS_APART
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define MAILLE_KEEPS_ARRAYS_APART
#endif
#endif
#if defined(__linux__) && !defined(MAILLE_KEEPS_ARRAYS_APART)
#define MAILLE_HAS_LARGE_PAGES
#include <sys/mman.h>
#endif

namespace maille {

/// Counters of an arena, reference-counted by the arena, the arenas inside it, and its charges.
class Arena::Ledger {
public:
  Ledger(std::int64_t limit, Ledger* around) : limit_(limit), around_(around) {
    if (around_ != nullptr)
      around_->keep();
  }

  /// @return false, without counting, if this would exceed an enforced limit
  bool take(std::int64_t bytes, bool may_refuse) {
    const std::int64_t now = present_ += bytes;
    if ((may_refuse && now > limit_) || (around_ != nullptr && !around_->take(bytes, may_refuse))) {
      present_ -= bytes;
      return false;
    }
    for (std::int64_t most = peak_; now > most && !peak_.compare_exchange_weak(most, now);) {
    }
    return true;
  }
  void give_back(std::int64_t bytes) {
    for (Ledger* at = this; at != nullptr; at = at->around_)
      at->present_ -= bytes;
  }
  void keep() { ++keepers_; }
  void let_go() {
    if (--keepers_ > 0)
      return;
    Ledger* const around = around_;
    delete this;
    if (around != nullptr)
      around->let_go();
  }
  std::int64_t present() const { return present_; }
  std::int64_t peak() const { return peak_; }

private:
  std::atomic<std::int64_t> present_{0}, peak_{0}, keepers_{1};
  const std::int64_t limit_;
  Ledger* const around_;
};

namespace {

thread_local Arena::Ledger* open_ledger = nullptr;
thread_local bool may_refuse = false;

/// Header before charged memory: its ledger and size.
struct Head {
  Arena::Ledger* ledger;
  std::int64_t bytes;
};

Arena::Ledger* take_from_open(std::size_t bytes) {
  if (open_ledger == nullptr)
    return nullptr;
  if (!open_ledger->take(static_cast<std::int64_t>(bytes), may_refuse))
    throw ArenaIsFull();
  open_ledger->keep();
  return open_ledger;
}

void give_back(Arena::Ledger* ledger, std::int64_t bytes) {
  if (ledger == nullptr)
    return;
  ledger->give_back(bytes);
  ledger->let_go();
}

} // namespace

Arena::Arena(std::int64_t limit) : ledger_(new Ledger(limit, open_ledger)) {}

Arena::~Arena() {
  ledger_->let_go();
}

std::int64_t Arena::present() const {
  return ledger_->present();
}

std::int64_t Arena::peak() const {
  return ledger_->peak();
}

Arena::Open::Open(Ledger* ledger, bool refuses)
    : before_(std::exchange(open_ledger, ledger)), could_refuse_(std::exchange(may_refuse, refuses)) {}

Arena::Open::~Open() {
  open_ledger = before_;
  may_refuse = could_refuse_;
}

Arena::Ledger* Arena::open_on_this_thread() {
  return open_ledger;
}

Charge::Charge(std::size_t bytes) : ledger_(take_from_open(bytes)), bytes_(bytes) {}

Charge::~Charge() {
  give_back(ledger_, static_cast<std::int64_t>(bytes_));
}

namespace {

#ifdef MAILLE_HAS_LARGE_PAGES

constexpr std::size_t cache_line = 64;

/// MAILLE_ARRAYS=heap disables huge pages, for heap profilers: docs/robustness.md
bool are_in_large_pages(std::size_t bytes) {
  constexpr std::size_t least = std::size_t{64} << 10;
  if (bytes < least)
    return false;
  static const bool are = [] {
    const char* const place = std::getenv("MAILLE_ARRAYS");
    return place == nullptr || std::string_view(place) != "heap";
  }();
  return are;
}

constexpr std::size_t rounded_up(std::size_t bytes, std::size_t unit) {
  return (bytes + unit - 1) / unit * unit;
}

/// Regions of huge pages; each array takes the first gap that it fits into. A shared object loaded at run
/// time has its own regions; memory returns to the owner of its region.
class LargePages {
public:
  void* take(std::size_t bytes) {
    const std::size_t size = rounded_up(bytes, cache_line);
    const std::lock_guard lock(mutex_);
    auto gap = gaps_.begin();
    while (gap != gaps_.end() && gap->second < size)
      ++gap;
    if (gap == gaps_.end())
      gap = add_region(size);
    char* const memory = gap->first;
    const std::size_t left = gap->second - size;
    gap = gaps_.erase(gap);
    if (left > 0)
      gaps_.emplace_hint(gap, memory + size, left);
    return memory;
  }
  static void give_back(void* memory, std::size_t bytes) noexcept {
    char* const at = static_cast<char*>(memory);
    auto* const region = reinterpret_cast<Region*>(at - reinterpret_cast<std::uintptr_t>(at) % alignment);
    region->owner->widen_gap(at, at + rounded_up(bytes, cache_line), *region);
  }
  /// Never destroyed, because static destructors may still free arrays.
  static LargePages& all() {
    static LargePages* const pages = [] {
      // Without this, a forked child could wait forever for a lock that another thread held.
      const auto unlock = [] { all().mutex_.unlock(); };
      pthread_atfork([] { all().mutex_.lock(); }, unlock, unlock);
      return new LargePages;
    }();
    return *pages;
  }

private:
  /// Header of a region. Its arrays begin within the region's alignment, which is also its size unless one
  /// array needs more.
  struct alignas(cache_line) Region {
    LargePages* owner;
    std::size_t size;
    char* first() { return reinterpret_cast<char*>(this + 1); }
    char* end() { return reinterpret_cast<char*>(this) + size; }
  };
  static constexpr std::size_t large_page = std::size_t{2} << 20, alignment = 16 * large_page;

  void widen_gap(char* begin, char* end, Region& region) noexcept {
    const std::lock_guard lock(mutex_);
    auto next = gaps_.lower_bound(begin);
    if (next != gaps_.end() && next->first == end && end < region.end()) {
      end += next->second;
      next = gaps_.erase(next);
    }
    if (next != gaps_.begin() && begin > region.first())
      if (const auto before = std::prev(next); before->first + before->second == begin) {
        begin = before->first;
        next = gaps_.erase(before);
      }
    if (begin == region.first() && end == region.end())
      munmap(&region, rounded_up(region.size, large_page));
    else
      gaps_.emplace_hint(next, begin, static_cast<std::size_t>(end - begin));
  }

  std::map<char*, std::size_t>::iterator add_region(std::size_t least) {
    const std::size_t size = std::max(least + sizeof(Region), alignment);
    auto* const region = new (map_aligned(rounded_up(size, large_page), alignment)) Region{this, size};
    return gaps_.emplace(region->first(), size - sizeof(Region)).first;
  }

  std::mutex mutex_;
  std::map<char*, std::size_t> gaps_; ///< size of each gap by its address
};

#endif

} // namespace

void* allocate_array(std::size_t bytes, std::size_t alignment) {
#ifdef MAILLE_HAS_LARGE_PAGES
  if (are_in_large_pages(bytes))
    return LargePages::all().take(bytes);
#endif
  return ::operator new (bytes, std::align_val_t{alignment});
}

void release_array(void* memory, [[maybe_unused]] std::size_t bytes, std::size_t alignment) noexcept {
#ifdef MAILLE_HAS_LARGE_PAGES
  if (are_in_large_pages(bytes)) {
    LargePages::give_back(memory, bytes);
    return;
  }
#endif
  ::operator delete (memory, std::align_val_t{alignment});
}

void* allocate_charged(std::size_t bytes, std::size_t alignment) {
  static_assert(sizeof(Head) <= 16);
  const std::size_t all = bytes + alignment;
  const Head head{take_from_open(all), static_cast<std::int64_t>(all)};
  void* begin = nullptr;
  try {
    begin = allocate_array(all, alignment);
  } catch (const std::bad_alloc&) {
    give_back(head.ledger, head.bytes);
    throw;
  }
  return reinterpret_cast<char*>(new (begin) Head(head)) + alignment;
}

void release_charged(void* memory, std::size_t alignment) noexcept {
  char* const begin = static_cast<char*>(memory) - alignment;
  const Head head = *reinterpret_cast<Head*>(begin);
  release_array(begin, static_cast<std::size_t>(head.bytes), alignment);
  give_back(head.ledger, head.bytes);
}

} // namespace maille
