#include "parallel/thread_team.hpp"

#include <system_error>

#if defined(__linux__)
#include <pthread.h>
#include <sched.h>
#endif

namespace maille::deform {

namespace {

/// Polls before sleeping: about 20 microseconds. Waking a thread takes longer.
constexpr int looks_before_sleep = 1000;

void pause_a_little() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#endif
}

void pause_or_yield(int looks) {
  if (looks < looks_before_sleep)
    pause_a_little();
  else
    std::this_thread::yield();
}

#if defined(__linux__)
int present_processor() {
  return sched_getcpu();
}

/// A woken thread often starts on the processor of its waker and stays there for longer than most loops take,
/// with other processors idle, especially on virtual machines.
void keep_off(std::thread& thread, int processor) {
  cpu_set_t allowed;
  if (processor < 0 || sched_getaffinity(0, sizeof allowed, &allowed) != 0 || CPU_COUNT(&allowed) < 2 ||
      processor >= CPU_SETSIZE)
    return;
  CPU_CLR(static_cast<std::size_t>(processor), &allowed);
  pthread_setaffinity_np(thread.native_handle(), sizeof allowed, &allowed); // best effort
}
#else
int present_processor() {
  return -1;
}
void keep_off(std::thread&, int) {}
#endif

} // namespace

ThreadTeam::ThreadTeam(int threads) {
  others_.reserve(std::max(threads - 1, 0));
  try {
    for (int i = 1; i < threads; ++i)
      others_.emplace_back([this, i] { serve(i); });
  } catch (const std::system_error&) { // no memory for another stack: the existing threads do the work
  }
}

ThreadTeam::~ThreadTeam() {
  ending_ = true;
  ++loop_;
  loop_.notify_all();
  for (std::thread& other : others_)
    other.join();
}

void ThreadTeam::take_items(int thread) {
  for (int item = next_item_++; item < n_items_; item = next_item_++)
    call_(callable_, item, thread);
}

void ThreadTeam::run_all(int n_items, Call call, void* callable) {
  const Arena::Open open(Arena::open_on_this_thread());
  if (others_.empty() || n_items <= 1) {
    for (int item = 0; item < n_items; ++item)
      call(callable, item, 0);
    return;
  }
  call_ = call;
  callable_ = callable;
  ledger_ = Arena::open_on_this_thread();
  n_items_ = n_items;
  next_item_ = 0;
  if (const int processor = present_processor(); processor != callers_) {
    callers_ = processor;
    for (std::thread& other : others_)
      keep_off(other, processor);
  }
  inside_ = 0;
  ++loop_;
  loop_.notify_all();
  take_items(0);
  // Closes the loop to helpers that have not joined.
  std::int32_t none = 0;
  for (int looks = 0; !inside_.compare_exchange_weak(none, -1); none = 0, ++looks)
    pause_or_yield(looks);
}

void ThreadTeam::wait_for(const std::atomic<bool>& is_done) {
  for (int looks = 0; !is_done; ++looks)
    pause_or_yield(looks);
}

bool ThreadTeam::join() {
  std::int32_t count = inside_.load();
  while (count >= 0)
    if (inside_.compare_exchange_weak(count, count + 1))
      return true;
  return false;
}

std::uint32_t ThreadTeam::wait_for_loop(std::uint32_t seen) {
  for (int looks = 0; looks < looks_before_sleep; ++looks) {
    if (loop_.load() != seen)
      return loop_.load();
    pause_a_little();
  }
  loop_.wait(seen);
  return loop_.load();
}

void ThreadTeam::serve(int thread) {
  std::uint32_t seen = 0;
  while (!ending_) {
    seen = wait_for_loop(seen);
    if (!join())
      continue;
    {
      const Arena::Open open(ledger_);
      take_items(thread);
    }
    --inside_;
  }
}

} // namespace maille::deform
