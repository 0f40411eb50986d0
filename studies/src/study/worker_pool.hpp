#pragma once
/// A pool of forked worker processes for numbered tasks, and a check for other load on the machine.
///
/// A worker that dies takes only its task with it and is replaced. Tasks and results travel through sockets
/// as text; the parent alone delivers them. SIGINT reaches only the parent, which asks workers to end, and
/// gives them five seconds. Fork comes before any thread is started, because a forked child has only the
/// calling thread.
///
/// MachineWatch is heuristic: processor share and load average say whether times of a row can be trusted.

#include <chrono>
#include <functional>
#include <string>

namespace maille::studies {

/// What became of a task.
struct TaskResult {
  std::size_t task = 0;
  std::string text;  ///< what `work` returned
  std::string death; ///< not empty: its process died, in words; then there is no text
};

/// @brief Works through tasks 0 .. n_tasks - 1 with `n_workers` forked processes; `deliver` is called here,
/// in the order in which tasks end.
///
/// A process that dies is replaced. Workers do not hear SIGINT, which a terminal sends to all: this process
/// decides. They end when it does, however that happens.
///
/// @param work     runs in a worker; asked to end early where `should_stop` there says so
/// @param should_stop_here  polled ten times a second; once true, workers are asked to end and have five
///        seconds for it
/// @pre  this process has no threads that hold locks
/// @throws std::system_error where no process can be made
void work_through(
    std::size_t n_tasks, int n_workers,
    const std::function<std::string(std::size_t task, const std::function<bool()>& should_stop)>& work,
    const std::function<void(const TaskResult&)>& deliver, const std::function<bool()>& should_stop_here);

/// Begins to watch when it is made.
class MachineWatch {
public:
  MachineWatch();
  /// Processor seconds of this process and its children over wall seconds since then.
  double processor_share() const;
  /// Load average of one minute, at construction.
  double load_average() const { return load_average_; }
  /// True if others wanted the processors: more wanted to run than there are, or this process, which never
  /// waits for anything else, stood still.
  bool was_busy() const;

private:
  double processor_start_, load_average_;
  std::chrono::steady_clock::time_point start_;
};

} // namespace maille::studies
