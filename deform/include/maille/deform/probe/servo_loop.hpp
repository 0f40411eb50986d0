#pragma once
/// The loop that feels: a thread of its own, woken every millisecond.

#include "maille/deform/probe/latency_histogram.hpp"
#include "maille/deform/probe/probe.hpp"

#include <atomic>
#include <thread>
#include <vector>

namespace maille::deform {

struct ServoSettings {
  std::int64_t ticks = 1000; ///< at most; > 0
  bool in_real_time = true;  ///< false: tick after tick without a clock; latencies are then those of the work
  bool wants_priority = true; ///< over other threads (SCHED_FIFO), where the system lets it
};

/// One tick, as it is kept.
struct ServoSample {
  double time;          ///< since the loop began [s]; without a clock the tick's number times the period
  std::int64_t latency; ///< from when the tick was due until its force was written [ns]
  ProbeState state;
};

struct ServoReport {
  /// From when a tick was due until its force was written: waking up, reading, arithmetic, writing.
  LatencyHistogram latency;
  /// Of that, without waking up.
  LatencyHistogram work;
  std::int64_t ticks = 0;
  /// Periods at whose end the force was not yet written. A tick that is late takes the places of those that were due meanwhile: they are left
  /// out and counted here, so that the loop never runs behind.
  std::int64_t missed = 0;
  bool had_priority = false;
  std::vector<ServoSample> samples; ///< of every tick
};

/// Reads a device, lets a probe tick, and writes the force, at the probe's period. Physics runs beside it, in other threads (see ContactPhysics).
///
/// Memory is asked for before the loop begins, not in it. On Linux the thread sleeps to an absolute time, wakes within a microsecond of
/// slack, and takes real-time priority where it may.
class ServoLoop {
public:
  /// Begins. @param device, probe must outlive the loop, and are its alone until it has ended
  ServoLoop(ProbeDevice& device, Probe& probe, const ServoSettings& settings);
  ~ServoLoop();
  ServoLoop(const ServoLoop&) = delete;
  ServoLoop& operator=(const ServoLoop&) = delete;

  void stop() { stopping_ = true; }
  bool has_ended() const { return has_ended_.load(std::memory_order_acquire); }
  /// Waits until the loop has ended.
  const ServoReport& wait();

private:
  void run();
  void tick(std::int64_t began, std::int64_t due);

  ProbeDevice* device_;
  Probe* probe_;
  ServoSettings settings_;
  ServoReport report_;
  std::atomic<bool> stopping_{false}, has_ended_{false};
  std::thread thread_;
};

} // namespace maille::deform
