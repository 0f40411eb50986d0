#pragma once
/// The clock of one run and the caller's wish to end it, also of what libraries do in one piece, for hours
/// maybe.

#include "maille/scene/answer.hpp"

#include <chrono>
#include <functional>

namespace maille::fem_ref {

class Watch {
public:
  explicit Watch(const Control& control) : control_(&control), start_(Clock::now()) {}

  int threads() const { return control_->threads < 1 ? 1 : control_->threads; }
  double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  /// True once the caller asks to stop or the seconds are used up, and from then on; see `status`.
  bool should_stop();
  /// Someone else has asked to stop.
  void stop(Status why) { status_ = why; }
  /// interrupted or budget_reached
  Status status() const { return status_; }
  void report(double fraction, std::string_view what) const {
    if (control_->progress)
      control_->progress(fraction, what);
  }
  /// Leaves out of the clock what a process pays once, whatever it solves.
  void exclude(double seconds) {
    start_ += std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  }

private:
  using Clock = std::chrono::steady_clock;
  const Control* control_;
  Clock::time_point start_;
  Status status_ = Status::done;
};

/// Runs `work` in a thread of its own while the calling thread asks `control` whether to stop, and reports
/// its progress. Work that has not ended 0.3 s after a request to stop is abandoned: it runs until it sees
/// the request, and its result is lost. Without a way to stop, or memory for a thread, the calling thread
/// does the work.
/// @param work  must not throw. It may outlive the caller: what it uses has to be its own, and the Control
///              that it is given, which lets the calling thread call the caller's functions while that waits,
///              and afterwards says "stop"
/// @return false where the work was left behind; see works_left_behind()
bool run_abandonable(const Control& control, const std::function<void(const Control&)>& work);

} // namespace maille::fem_ref
