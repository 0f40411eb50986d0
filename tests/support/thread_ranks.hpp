#pragma once
/// Ranks as threads of one process.

#include "maille/base/communicator.hpp"

#include <algorithm>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <map>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace maille::test {

/// Calls work(communicator) in `size` threads, and returns the results by rank.
template<class Work>
auto in_ranks(int size, const Work& work) {
  struct Mail {
    std::mutex mutex;
    std::condition_variable came;
    std::map<std::pair<int, int>, std::deque<std::vector<std::byte>>> waiting; ///< by sender and receiver
  };
  class Rank : public Communicator {
  public:
    Rank(Mail& mail, int rank, int size) : mail_(mail), rank_(rank), size_(size) {}
    int rank() const override { return rank_; }
    int size() const override { return size_; }
    void exchange(std::span<const Part> to, std::span<const Part> from) override {
      {
        const std::lock_guard lock(mail_.mutex);
        for (const Part& part : to)
          mail_.waiting[{rank_, part.rank}].emplace_back(part.bytes.begin(), part.bytes.end());
      }
      mail_.came.notify_all();
      for (const Part& part : from) {
        std::unique_lock lock(mail_.mutex);
        auto& waiting = mail_.waiting[{part.rank, rank_}];
        mail_.came.wait(lock, [&] { return !waiting.empty(); });
        if (waiting.front().size() != part.bytes.size())
          std::terminate(); // otherwise the other ranks would wait for ever
        std::ranges::copy(waiting.front(), part.bytes.begin());
        waiting.pop_front();
      }
    }

  private:
    Mail& mail_;
    int rank_, size_;
  };
  Mail mail;
  std::vector<decltype(work(std::declval<Communicator&>()))> results(static_cast<std::size_t>(size));
  std::vector<std::thread> threads;
  for (int rank = 0; rank < size; ++rank)
    threads.emplace_back([&, rank] {
      Rank own(mail, rank, size);
      results[static_cast<std::size_t>(rank)] = work(static_cast<Communicator&>(own));
    });
  for (std::thread& thread : threads)
    thread.join();
  return results;
}

} // namespace maille::test
