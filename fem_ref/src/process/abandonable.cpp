

#include "process/abandonable.hpp"

#include "maille/fem_ref/ranks.hpp"

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <system_error>
#include <thread>

namespace maille::fem_ref {

bool Watch::should_stop() {
  if (status_ != Status::done)
    return true;
  if (control_->should_stop())
    status_ = Status::interrupted;
  else if (control_->seconds_budget && seconds() > *control_->seconds_budget)
    status_ = Status::budget_reached;
  return status_ != Status::done;
}

namespace {

using Clock = std::chrono::steady_clock;
constexpr auto between_looks = std::chrono::milliseconds(10);
constexpr auto grace = std::chrono::milliseconds(300); ///< time for iterations to return their present state

std::atomic<int> left_behind{0};

/// Communication between the thread and its caller.
class Link {
public:
  // The thread's side.
  bool should_stop() {
    const std::scoped_lock lock(mutex_);
    return should_stop_;
  }
  /// Waits until the caller has forwarded the report, so that a stop request at that progress takes effect
  /// there.
  void report(double fraction, std::string_view what) {
    std::unique_lock lock(mutex_);
    if (is_left_)
      return;
    fraction_ = fraction;
    what_ = what;
    has_news_ = true;
    changed_.notify_all();
    changed_.wait(lock, [this] { return !has_news_ || is_left_; });
  }
  void end() {
    const std::scoped_lock lock(mutex_);
    has_ended_ = true;
    if (is_left_)
      --left_behind;
    changed_.notify_all();
  }

  // The caller's side.
  /// @return false if the work has not ended in time
  bool wait_for_end(const Control& control) {
    std::unique_lock lock(mutex_);
    Clock::time_point deadline = Clock::time_point::max();
    while (!has_ended_) {
      changed_.wait_for(lock, between_looks, [this] { return has_ended_ || has_news_; });
      const bool has_news = has_news_;
      lock.unlock(); // the caller's functions may be slow, and may throw
      if (has_news)  // the thread waits, so both stay unchanged
        control.progress(fraction_, what_);
      const bool is_asked = control.should_stop();
      lock.lock();
      if (is_asked && !should_stop_)
        deadline = Clock::now() + grace;
      should_stop_ = should_stop_ || is_asked;
      has_news_ = has_news_ && !has_news;
      changed_.notify_all();
      if (!has_ended_ && Clock::now() > deadline)
        return false;
    }
    return true;
  }
  void leave() {
    const std::scoped_lock lock(mutex_);
    is_left_ = should_stop_ = true;
    if (!has_ended_)
      ++left_behind;
    changed_.notify_all();
  }

private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool should_stop_ = false, has_ended_ = false, is_left_ = false, has_news_ = false;
  double fraction_ = 0;
  std::string what_;
};

/// A thread that is joined if its work has ended, and detached if the caller leaves first, also by an
/// exception.
class Companion {
public:
  Companion(std::thread thread, Link& link) : thread_(std::move(thread)), link_(link) {}
  Companion(const Companion&) = delete;
  Companion& operator=(const Companion&) = delete;
  ~Companion() {
    if (!thread_.joinable())
      return;
    link_.leave();
    thread_.detach();
  }
  void join() { thread_.join(); }

private:
  std::thread thread_;
  Link& link_;
};

} // namespace

int works_left_behind() {
  return left_behind;
}

bool run_abandonable(const Control& control, const std::function<void(const Control&)>& work) {
  if (!control.stop_requested || control.should_stop()) {
    work(control);
    return true;
  }
  const auto link = std::make_shared<Link>();
  Control own = control;
  own.stop_requested = [link] { return link->should_stop(); };
  if (control.progress)
    own.progress = [link](double fraction, std::string_view what) { link->report(fraction, what); };
  std::thread thread;
  try {
    thread = std::thread([link, own, work] {
      work(own);
      link->end();
    });
  } catch (const std::system_error&) {
    work(control);
    return true;
  }
  Companion companion(std::move(thread), *link);
  const bool has_ended = link->wait_for_end(control);
  if (has_ended)
    companion.join();
  return has_ended;
}

} // namespace maille::fem_ref
