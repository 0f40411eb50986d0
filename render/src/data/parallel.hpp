#pragma once
/// Processes tiles by several threads. Private to render.
///
/// Threads take the next item from one counter: empty tiles cost nothing, so equal shares would not be equal
/// work.

#include <algorithm>
#include <atomic>
#include <exception>
#include <thread>
#include <vector>

namespace maille::render {

/// Calls work(item, thread) once for every item 0 ... n_items - 1, in any order; results must not depend on
/// the order. Rethrows an exception of any item after all threads have ended.
template<class Work>
void for_each_item(int threads, int n_items, Work&& work) {
  const int n_threads = std::clamp(threads, 1, std::max(1, n_items));
  if (n_threads == 1) {
    for (int item = 0; item < n_items; ++item)
      work(item, 0);
    return;
  }
  std::atomic<int> next{0};
  std::vector<std::exception_ptr> thrown(n_threads);
  const auto take = [&](int thread) {
    try {
      for (int item = next++; item < n_items; item = next++)
        work(item, thread);
    } catch (...) {
      thrown[thread] = std::current_exception();
      next = n_items;
    }
  };
  {
    std::vector<std::jthread> others;
    for (int thread = 1; thread < n_threads; ++thread)
      others.emplace_back(take, thread);
    take(0);
  }
  for (const std::exception_ptr& exception : thrown)
    if (exception)
      std::rethrow_exception(exception);
}

} // namespace maille::render
