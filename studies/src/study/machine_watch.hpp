#pragma once
/// Whether the processors were ours while something was timed.

#include <chrono>

namespace maille::studies {

/// Begins to watch when it is made.
class MachineWatch {
public:
  MachineWatch();
  /// Processor seconds of this process and its children over wall seconds since then.
  double processor_share() const;
  /// Of one minute, when it was made.
  double load_average() const { return load_average_; }
  /// True if others wanted the processors: more wanted to run than there are, or this process, which never
  /// waits for anything else, stood still.
  bool was_busy() const;

private:
  double processor_start_, load_average_;
  std::chrono::steady_clock::time_point start_;
};

} // namespace maille::studies
