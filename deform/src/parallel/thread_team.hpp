#pragma once
/// Threads that stay, for loops of microseconds.

#include <atomic>
#include <cstdint>
#include <thread>
#include <type_traits>
#include <vector>

namespace maille::deform {

/// The caller and threads - 1 others. The others sleep between loops, after waiting awake for a moment, as
/// drags come in bursts. A loop ends when its items are done; it does not wait for threads that were too late
/// to take one. Nothing is allocated after construction.
///
/// Not for use by two callers at a time.
class ThreadTeam {
public:
  /// @param threads at least 1; no more than items will ever be used. Fewer, where the system gives no more
  explicit ThreadTeam(int threads);
  ~ThreadTeam();
  ThreadTeam(const ThreadTeam&) = delete;
  ThreadTeam& operator=(const ThreadTeam&) = delete;

  int threads() const { return static_cast<int>(others_.size()) + 1; }

  /// Calls work(item, thread) once for every item in 0 ... n_items - 1, on any of the threads 0 ...
  /// threads() - 1, in any order. `work` must not throw, and what it writes must not depend on the order.
  template<class Work>
  void run(int n_items, Work&& work) {
    using Callable = std::remove_reference_t<Work>;
    const auto call = [](void* callable, int item, int thread) {
      (*static_cast<Callable*>(callable))(item, thread);
    };
    run_all(n_items, call, const_cast<void*>(static_cast<const void*>(&work)));
  }

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
  int n_items_ = 0;

  std::atomic<int> next_item_{0};
  std::atomic<std::uint32_t> loop_{0};   ///< counts loops
  std::atomic<std::int32_t> inside_{-1}; ///< helpers at work; -1: the gate is shut
  std::atomic<bool> ending_{false};
  std::vector<std::thread> others_;
};

} // namespace maille::deform
