#pragma once
/// The memory of arrays, counted as they are allocated, and a limit to it.
///
/// An Arena is opened on a thread; every List and field that the thread then allocates carries a Charge for
/// its bytes. Arenas nest: the inner one counts for the outer ones too. present() and peak() are exact for
/// these arrays; small objects outside of them are not counted. Past the limit ArenaIsFull is thrown before
/// the memory is taken, which solve() turns into a refusal.

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

/// Thrown where arrays would take more than an open arena may hold.
class ArenaIsFull : public std::bad_alloc {
public:
  const char* what() const noexcept override { return "the arrays of an arena would pass its limit"; }
};

/// Arrays that outlive it are counted until they are gone. May be asked from any thread, and open on several.
class Arena {
public:
  static constexpr std::int64_t no_limit = std::numeric_limits<std::int64_t>::max();

  /// Within the arena that is open on this thread, if there is one. @param limit [bytes]
  explicit Arena(std::int64_t limit = no_limit);
  ~Arena();
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;

  std::int64_t present() const; ///< [bytes]
  std::int64_t peak() const;    ///< [bytes]

  class Ledger;
  /// Opens an arena on this thread, and again the one before when it goes.
  class Open {
  public:
    explicit Open(const Arena& arena) : Open(arena.ledger_, true) {}
    /// For threads that work for another one: they count, and nothing is refused to them, so that they need
    /// not throw. @param of open_on_this_thread() of that one
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

/// Bytes that stand in the arena that was open when they were charged.
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

/// Memory for an array: small ones are the heap's, others lie side by side in pages of the largest kind where
/// the system grants them, which come in a tenth of the time. What is given back is there for the next ones,
/// and the system's again once nothing is left in 32 MiB. May be called from any thread.
/// @param alignment 64 at most
/// @return memory with anything in it @throws std::bad_alloc
void* allocate_array(std::size_t bytes, std::size_t alignment);
/// @param bytes as were asked for
void release_array(void* memory, std::size_t bytes, std::size_t alignment) noexcept;

/// Memory for an array with its charge before it. @throws std::bad_alloc @param alignment 16 at least
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

/// A std::vector that an open arena counts: for what grows with a body.
template<class T>
using List = std::vector<T, ChargedAllocator<T>>;

// ---- how much the process can still have, and how large arrays are requested ------------------------------

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
