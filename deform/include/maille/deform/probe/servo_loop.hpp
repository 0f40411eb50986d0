#pragma once
/// The real-time loop of a probe (1 kHz), and a world that it touches.
///
/// A tick reads the device, computes the force (Probe) and writes it; it neither allocates nor locks nor
/// waits. Elastic answers come from other threads through triple buffers (ContactPhysics). A late tick skips
/// the ticks that it missed and counts them: the loop never tries to catch up. Latency counts from the time
/// when the tick was due.

#include "maille/deform/probe/probe.hpp"
#include "maille/deform/probe/touch.hpp"
#include "maille/deform/world/world.hpp"

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace maille::deform {

/// Durations from 0 to 18 minutes in bins a thirty-second of an octave wide: 3 % at most, and one nanosecond
/// below 32.
class LatencyHistogram {
public:
  void add(std::int64_t nanoseconds);

  std::int64_t n() const { return n_; }
  std::int64_t largest() const { return largest_; }                           ///< exactly [ns]
  double mean() const { return n_ > 0 ? sum_ / static_cast<double>(n_) : 0; } ///< [ns]
  /// The smallest duration that at least this share of all is not above, to the upper end of its bin [ns]; 0
  /// of none.
  /// @param share 0 to 1
  std::int64_t quantile(double share) const;

  struct Bin {
    std::int64_t from, to; ///< [ns], `to` is in it
    std::int64_t count;
  };
  /// Those that are not empty, in order.
  std::vector<Bin> bins() const;

private:
  static constexpr int bits = 5, octaves = 36;
  static std::size_t bin_of(std::int64_t nanoseconds);
  static std::int64_t begin_of(std::size_t bin);

  std::array<std::int64_t, static_cast<std::size_t>(octaves) << bits> counts_{};
  std::int64_t n_ = 0, largest_ = 0;
  double sum_ = 0;
};

/// The clock of loops at 1 kHz, that of std::chrono::steady_clock. Times in ns.
class ServoClock {
public:
  static std::int64_t now();
  static void sleep_until(std::int64_t due);
  /// Has this thread go before others, and wake within a microsecond, where the system lets it (Linux).
  /// @param above_others part of the range of real-time priorities, 0 to 1 @return whether it does
  static bool take_priority(double above_others);
};

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
  /// The same without the time to wake up.
  LatencyHistogram work;
  std::int64_t ticks = 0;
  /// Periods at whose end the force was not yet written. A tick that is late takes the places of those that
  /// were due meanwhile: they are left out and counted here, so that the loop never runs behind.
  std::int64_t missed = 0;
  bool had_priority = false;
  std::vector<ServoSample> samples; ///< of every tick
};

/// Reads a device, lets a probe tick, and writes the force, at the probe's period. Physics runs beside it, in
/// other threads (see ContactPhysics).
///
/// Memory is asked for before the loop begins, not in it. On Linux the thread sleeps to an absolute time,
/// wakes within a microsecond of slack, and takes real-time priority where it may.
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

/// What a tool in a world may run into: the other rigid objects in a map of their own, and the surfaces of
/// deformable ones where they are now. Never changes.
struct ToolSurroundings {
  std::shared_ptr<const RigidWorld> rigid; ///< whose map `matter` points to
  std::vector<std::shared_ptr<const BodySurface>> bodies;
  std::shared_ptr<const Surroundings> matter;
};
/// @param tool object of the world that is left out; -1: none
/// @throws std::invalid_argument for deformable objects of other than three dimensions
ToolSurroundings surroundings_of(const World& world, int tool);

/// Fixed and rigid objects in one map, the surfaces of deformable ones at rest, and what answers how stiff
/// these are. Nothing of it moves but the probe's tool.
class ProbedWorld {
public:
  /// @param tool the rigid object that the hand holds; -1: a point of one cell's voxel @param radius of the
  ///        footprint, see ContactSolver [m]
  /// @throws std::invalid_argument for objects that overlap, deformable ones of other than three dimensions,
  ///         a tool that is not rigid
  ProbedWorld(const WorldScene& scene, int tool, double radius);
  /// One deformable body without walls about it: of the scene its body, materials, limits and holds. A point
  /// is the tool.
  ProbedWorld(const Scene& scene, double radius);

  const std::shared_ptr<const Surroundings>& surroundings() const { return around_.matter; }
  const RigidShape& tool() const { return *tool_; }
  /// Start pose of the tool's middle in the scene; empty for a point tool.
  const std::optional<Pose>& start() const { return start_; }
  int n_bodies() const { return static_cast<int>(bodies_.size()); }
  const std::string& name(int body) const { return at(body).name; }
  const ContactSolver& solver(int body) const { return *at(body).solver; }
  const Scene& scene(int body) const { return *at(body).scene; }
  std::int64_t bytes() const;

private:
  struct Body {
    std::string name;
    std::unique_ptr<Scene> scene;
    std::unique_ptr<ContactSolver> solver;
  };

  const Body& at(int body) const { return bodies_[body]; }
  /// Adds the body whose surface is the next one of `around_`.
  void add_body(const std::string& name, const Scene& scene, double radius);

  ToolSurroundings around_;
  std::vector<Body> bodies_;
  std::unique_ptr<RigidShape> tool_; ///< solvers know it by its place
  std::optional<Pose> start_;
};

} // namespace maille::deform
