#pragma once
/// A pool of forked worker processes for numbered tasks, and a check for other load on the machine.
///
/// A worker that dies loses only its task and is replaced. Tasks and results pass through sockets as text;
/// only the parent delivers results. SIGINT reaches only the parent, which requests workers to end within
/// five seconds. Fork before starting threads, because a forked child has only the calling thread.
///
/// MachineWatch is heuristic: processor share and load average say whether times of a row can be trusted.

#include <chrono>
#include <functional>
#include <string>

namespace maille::studies {

/// Result of a task.
struct TaskResult {
  std::size_t task = 0;
  std::string text;  ///< what `work` returned
  std::string death; ///< not empty: how its process died; then `text` is empty
};

/// @brief Processes tasks 0 .. n_tasks - 1 with `n_workers` forked processes; the calling process calls
/// `deliver` in order of completion.
///
/// A dead process is replaced. Workers ignore SIGINT, which a terminal sends to all processes: the parent
/// decides. They end when the parent ends, for whatever reason.
///
/// @param work     runs in a worker; should end early once its `should_stop` returns true
/// @param should_stop_here  polled ten times a second; once true, workers are requested to end within five
///        seconds
/// @pre  this process has no threads that hold locks
/// @throws std::system_error if no process can be created
void work_through(
    std::size_t n_tasks, int n_workers,
    const std::function<std::string(std::size_t task, const std::function<bool()>& should_stop)>& work,
    const std::function<void(const TaskResult&)>& deliver, const std::function<bool()>& should_stop_here);

/// Observes the machine from its construction on.
class MachineWatch {
public:
  MachineWatch();
  /// Processor seconds of this process and its children over wall seconds since then.
  double processor_share() const;
  /// Load average of one minute, at construction.
  double load_average() const { return load_average_; }
  /// True if there was other load: more runnable processes than processors, or this process, which never
  /// waits for anything else, was idle.
  bool was_busy() const;

private:
  double processor_start_, load_average_;
  std::chrono::steady_clock::time_point start_;
};

} // namespace maille::studies
