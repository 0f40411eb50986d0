#pragma once
/// Time limit and stop requests of one run, also during library calls that cannot be interrupted and may take
/// hours.

#include "maille/scene/answer.hpp"

#include <chrono>
#include <functional>

namespace maille::fem_ref {

class Watch {
public:
  explicit Watch(const Control& control) : control_(&control), start_(Clock::now()) {}

  int threads() const { return control_->threads < 1 ? 1 : control_->threads; }
  double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  /// True after a stop request or when the time is used up; stays true; see `status`.
  bool should_stop();
  /// Records a stop request from another source.
  void stop(Status why) { status_ = why; }
  /// interrupted or budget_reached
  Status status() const { return status_; }
  void report(double fraction, std::string_view what) const {
    if (control_->progress)
      control_->progress(fraction, what);
  }
  /// Excludes set-up time that a process pays once, independent of the problem.
  void exclude(double seconds) {
    start_ += std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  }

private:
  using Clock = std::chrono::steady_clock;
  const Control* control_;
  Clock::time_point start_;
  Status status_ = Status::done;
};

/// Runs `work` in its own thread while the calling thread polls `control` for stop requests and reports
/// progress. Work that has not ended 0.3 s after a stop request is abandoned: it runs until it checks for the
/// request, and its result is lost. If stopping is not possible, or memory does not suffice for a thread, the
/// calling thread does the work.
/// @param work  must not throw. It may outlive the caller, so it must own its data and use the Control passed
///              to it: this forwards calls to the caller's functions while the calling thread waits, and
///              afterwards always requests a stop
/// @return false if the work was abandoned; see works_left_behind()
bool run_abandonable(const Control& control, const std::function<void(const Control&)>& work);

} // namespace maille::fem_ref
