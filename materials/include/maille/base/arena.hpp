#pragma once
/// Counts the memory of arrays as they are allocated, and limits it.
///
/// An Arena is opened on a thread; every List and field that the thread then allocates has a Charge for its
/// bytes. Arenas nest: an inner one also counts for the outer ones. present() and peak() are exact for these
/// arrays; other small objects are not counted. An allocation beyond the limit throws ArenaIsFull before it
/// takes memory; solve() turns this into a refusal.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <new>
#include <string>
#include <utility>
#include <vector>

namespace maille {

/// Thrown if arrays would exceed the limit of an open arena.
class ArenaIsFull : public std::bad_alloc {
public:
  const char* what() const noexcept override { return "the arrays of an arena would pass its limit"; }
};

/// Arrays that outlive the arena stay counted until freed. Thread-safe; may be open on several threads.
class Arena {
public:
  static constexpr std::int64_t no_limit = std::numeric_limits<std::int64_t>::max();

  /// Nested in the arena that is open on this thread, if any. @param limit [bytes]
  explicit Arena(std::int64_t limit = no_limit);
  ~Arena();
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;

  std::int64_t present() const; ///< [bytes]
  std::int64_t peak() const;    ///< [bytes]

  class Ledger;
  /// Opens an arena on this thread; the destructor restores the previous one.
  class Open {
  public:
    explicit Open(const Arena& arena) : Open(arena.ledger_, true) {}
    /// For worker threads: they count without limit, so that they need not throw. @param of
    /// open_on_this_thread() of the thread that they work for
    explicit Open(Ledger* of) : Open(of, false) {}
    ~Open();
    Open(const Open&) = delete;
    Open& operator=(const Open&) = delete;

  private:
    Open(Ledger* ledger, bool may_refuse);
    Ledger* before_;
    bool could_refuse_;
  };
  static Ledger* open_on_this_thread();

private:
  Ledger* ledger_;
};

/// Bytes charged to the arena that was open at construction.
class Charge {
public:
  Charge() = default;
  /// @throws ArenaIsFull
  explicit Charge(std::size_t bytes);
  Charge(Charge&& other) noexcept
      : ledger_(std::exchange(other.ledger_, nullptr)), bytes_(std::exchange(other.bytes_, 0)) {}
  Charge& operator=(Charge&& other) noexcept {
    std::swap(ledger_, other.ledger_);
    std::swap(bytes_, other.bytes_);
    return *this;
  }
  ~Charge();

private:
  Arena::Ledger* ledger_ = nullptr;
  std::size_t bytes_ = 0;
};

/// Memory for an array: small ones come from the heap, others are packed into huge pages if the system grants
/// them, which is ten times faster. Freed memory is reused, and returned to the system when a region of 32
/// MiB is empty. Thread-safe.
/// @param alignment 64 at most
/// @return uninitialised memory @throws std::bad_alloc
void* allocate_array(std::size_t bytes, std::size_t alignment);
/// @param bytes as requested
void release_array(void* memory, std::size_t bytes, std::size_t alignment) noexcept;

/// Memory for an array, preceded by its charge. @throws std::bad_alloc @param alignment 16 at least
void* allocate_charged(std::size_t bytes, std::size_t alignment);
void release_charged(void* memory, std::size_t alignment) noexcept;

template<class T>
struct ChargedAllocator {
  using value_type = T;
  static constexpr std::size_t alignment = std::max<std::size_t>(16, alignof(T));
  ChargedAllocator() = default;
  template<class U>
  ChargedAllocator(const ChargedAllocator<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(allocate_charged(n * sizeof(T), alignment)); }
  void deallocate(T* memory, std::size_t) noexcept { release_charged(memory, alignment); }
  bool operator==(const ChargedAllocator&) const = default;
};

/// A std::vector that an open arena counts: for arrays that scale with the body.
template<class T>
using List = std::vector<T, ChargedAllocator<T>>;

// ---- how much the process can still have, and how large arrays are requested ------------------------------

/// Memory available to this process without swapping [bytes]: the minimum of the available memory of the
/// system, the rest of its control groups (a container, a batch job), and its own limits (ulimit -v, -d).
std::int64_t available_memory();

/// Remaining memory within the limits of this process' control group and its parents [bytes], versions 1 and
/// 2; cached files count as free. A very large number without a limit.
/// @param root  folder of `proc/self/cgroup` and `sys/fs/cgroup`
std::int64_t left_in_control_groups(const std::filesystem::path& root = "/");

/// A number of bytes as text, in the unit with at most three digits before the point: `384 bytes`,
/// `1.5 KiB`, `130 MiB`, `5.2 GiB`.
std::string bytes_in_words(double bytes);

/// Requests huge pages for memory that is not touched yet, if it is large: page faults take a tenth of the
/// time, and address translation is faster. The system may decline. Neighbours in the same pages belong to
/// the allocator too, so the request does them no harm.
void ask_for_large_pages(void* begin, std::size_t bytes);

#ifdef __linux__
/// Zeroed memory from the system, in huge pages if granted, starting at a multiple of `alignment`.
/// @param size whole pages [bytes] @param alignment a multiple of the page size @throws std::bad_alloc
void* map_aligned(std::size_t size, std::size_t alignment);
#endif

/// resize() of a vector in huge pages.
template<class Values>
void resize_in_large_pages(Values& values, std::size_t n, typename Values::value_type value = {}) {
  values.reserve(n);
  if (n > values.size())
    ask_for_large_pages(values.data() + values.size(), (n - values.size()) * sizeof value);
  values.resize(n, value);
}

} // namespace maille
