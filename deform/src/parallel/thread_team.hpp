#pragma once
/// A pool of threads for loops of microseconds, and pipelined passes over the planes of a grid.
///
/// A loop hands out items in ascending order; which thread takes an item is open. Results have the same bits
/// at any number of threads because each item writes only what belongs to it, and sums are taken per item
/// and added in the order of the items. Threads spin for a moment before they sleep.

#include "maille/base/arena.hpp"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <thread>
#include <type_traits>
#include <vector>

namespace maille::deform {

/// The caller and threads - 1 helpers. Helpers spin briefly between loops, because drags come in bursts, and
/// then sleep. A loop ends when its items are done; it does not wait for helpers that took none. Nothing is
/// allocated after construction.
///
/// Not for use by two callers at a time.
class ThreadTeam {
public:
  /// @param threads at least 1; an upper bound. Fewer if the system provides fewer
  explicit ThreadTeam(int threads);
  ~ThreadTeam();
  ThreadTeam(const ThreadTeam&) = delete;
  ThreadTeam& operator=(const ThreadTeam&) = delete;

  int threads() const { return static_cast<int>(others_.size()) + 1; }

  /// Calls work(item, thread) once for every item in 0 ... n_items - 1, on any of the threads 0 ...
  /// threads() - 1, begun in their order. `work` must not throw, and what it writes must not depend on the
  /// order. An arena that is open counts what `work` allocates, and refuses nothing.
  template<class Work>
  void run(int n_items, Work&& work) {
    using Callable = std::remove_reference_t<Work>;
    const auto call = [](void* callable, int item, int thread) {
      (*static_cast<Callable*>(callable))(item, thread);
    };
    run_all(n_items, call, const_cast<void*>(static_cast<const void*>(&work)));
  }

  /// For items that depend on earlier items.
  static void wait_for(const std::atomic<bool>& is_done);

private:
  using Call = void (*)(void*, int, int);
  void run_all(int n_items, Call call, void* callable);
  void take_items(int thread);
  void serve(int thread);
  bool join();
  std::uint32_t wait_for_loop(std::uint32_t seen);

  // What the present loop is; written only while the gate is shut.
  Call call_ = nullptr;
  void* callable_ = nullptr;
  Arena::Ledger* ledger_ = nullptr; ///< of the caller
  int n_items_ = 0;
  int callers_ = -1; ///< the caller's processor, which helpers avoid

  std::atomic<int> next_item_{0};
  std::atomic<std::uint32_t> loop_{0};   ///< counts loops
  std::atomic<std::int32_t> inside_{-1}; ///< active helpers; -1: no loop is open
  std::atomic<bool> ending_{false};
  std::vector<std::thread> others_;
};

/// Fewer nodes than this run on one thread: a second one costs more than it saves at 10 ns a node.
inline constexpr std::int64_t nodes_worth_threads = 4000;

/// The same for passes of about 1 ns a node.
inline constexpr std::int64_t nodes_worth_a_thread = 1 << 15;

/// Rows per work item: fewer cost overhead, more leave threads idle at the end.
inline constexpr int rows_per_item = 64;

/// Entries per part of for_parts(), a multiple of the vector length.
inline constexpr std::size_t entries_of_part = 4096;
constexpr std::size_t n_parts_of(std::size_t n) {
  return (n + entries_of_part - 1) / entries_of_part;
}
/// Calls work(first, end, part) for parts of n entries. Parts do not depend on the number of threads.
template<class Work>
void for_parts(std::size_t n, ThreadTeam& team, const Work& work) {
  team.run(static_cast<int>(n_parts_of(n)), [&](int item, int) {
    const auto part = static_cast<std::size_t>(item);
    work(part * entries_of_part, std::min(n, (part + 1) * entries_of_part), part);
  });
}

/// Calls work(slab) for all slabs, where only neighbouring slabs share data: even slabs first, and each odd
/// slab soon after both of its neighbours, while the shared data are in the cache. So the order of sums does
/// not depend on the number of threads.
template<class Work>
void run_slabs(ThreadTeam& team, int n_slabs, const Work& work) {
  std::vector<std::atomic<bool>> is_done(std::max(n_slabs, 0));
  // Even ones that are begun before any between: a thread that is done with one does not wait for another's.
  const int n_even = (n_slabs + 1) / 2, ahead = std::min(n_even, team.threads() + 1), later = n_even - ahead;
  const auto slab_of = [&](int item) { // of one thread 0, 2, 1, 4, 3, ...
    const int i = item - ahead;
    return i < 0                         ? 2 * item
           : i < 2 * later && i % 2 != 0 ? 2 * ahead + i - 1
                                         : 2 * (i < 2 * later ? i / 2 : i - later) + 1;
  };
  team.run(n_slabs, [&](int item, int) {
    const int slab = slab_of(item);
    for (int beside = slab - 1; slab % 2 != 0 && beside < std::min(slab + 2, n_slabs); beside += 2)
      ThreadTeam::wait_for(is_done[beside]);
    work(slab);
    is_done[slab] = true;
  });
}

/// The same for the slabs `first` to end - 1 of a larger range, in the same order.
template<class Work>
void run_slabs(ThreadTeam& team, int first, int end, const Work& work) {
  const int base = first / 2 * 2;
  run_slabs(team, end - base, [&](int slab) {
    if (base + slab >= first)
      work(base + slab);
  });
}

/// Calls stage(s, z) for all stages s = 0 ... n_stages - 1 and planes z = 0 ... n_planes - 1. Stage s of a
/// plane comes after stage s - 1 of the plane and its two neighbours, and before stage s + 1 of any of them;
/// so whatever a stage reads within one plane of its own is the same in any order and on any number of
/// threads. A plane goes through its stages while it is in the cache.
///
/// With more threads than one the grid is cut into slabs. Each goes through what it can do alone, a stage
/// less deep with every stage; what is left at the cuts comes second (Frigo and Strumpen 2005, trapezoids).
///
/// @param stage callable as stage(int s, int z), must not throw
template<class Stage>
void run_stages(ThreadTeam& team, int n_planes, int n_stages, Stage&& stage) {
  const int thinnest = 2 * n_stages + 4; // two cuts must not touch, nor the last planes, that look farther
  const int slabs = std::max(1, std::min(team.threads(), n_planes / thinnest));
  const auto cut = [&](int slab) { return static_cast<int>(std::int64_t{1} * n_planes * slab / slabs); };
  team.run(slabs, [&](int slab, int) {
    const int begin = cut(slab), end = cut(slab + 1);
    for (int z = begin; z < end + n_stages; ++z)
      for (int s = 0; s < n_stages; ++s) {
        const int first = slab == 0 ? begin : begin + s, last = slab == slabs - 1 ? end : end - s;
        if (z - s >= first && z - s < last)
          stage(s, z - s);
      }
  });
  if (slabs > 1)
    team.run(slabs - 1, [&](int slab, int) {
      const int at = cut(slab + 1);
      for (int s = 1; s < n_stages; ++s)
        for (int z = at - s; z < at + s; ++z)
          stage(s, z);
    });
}

} // namespace maille::deform
