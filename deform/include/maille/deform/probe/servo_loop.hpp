#pragma once
/// The real-time loop of a probe (1 kHz), and the world that it touches.
///
/// A tick reads the device, computes the force (Probe) and writes it, without allocation, locks or waits.
/// Elastic answers come from other threads through triple buffers (ContactPhysics). A late tick skips the
/// missed ticks and counts them: the loop never tries to catch up. Latency is measured from the time when the
/// tick was due.

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

/// Histogram of durations from 0 to 18 minutes. Bins are a thirty-second of an octave wide: at most 3 %, and
/// one nanosecond below 32.
class LatencyHistogram {
public:
  void add(std::int64_t nanoseconds);

  std::int64_t n() const { return n_; }
  std::int64_t largest() const { return largest_; }                           ///< exact [ns]
  double mean() const { return n_ > 0 ? sum_ / static_cast<double>(n_) : 0; } ///< [ns]
  /// The smallest duration that at least this share of all durations does not exceed, rounded up to the end
  /// of its bin [ns]; 0 if empty.
  /// @param share 0 to 1
  std::int64_t quantile(double share) const;

  struct Bin {
    std::int64_t from, to; ///< [ns], including `to`
    std::int64_t count;
  };
  /// Bins that are not empty, in order.
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
  std::int64_t ticks = 1000;  ///< largest number, > 0
  bool in_real_time = true;   ///< false: no clock; latencies are then those of the work
  bool wants_priority = true; ///< requests SCHED_FIFO; used if the system permits
};

/// Record of one tick.
struct ServoSample {
  double time;          ///< since the start [s]; without a clock: number times period
  std::int64_t latency; ///< from its due time until its force was written [ns]
  ProbeState state;
};

struct ServoReport {
  /// From the due time of a tick until its force was written: waking up, reading, computing, writing.
  LatencyHistogram latency;
  /// The same without waking up.
  LatencyHistogram work;
  std::int64_t ticks = 0;
  /// Periods whose force was not written in time. A late tick replaces the ticks that were due meanwhile:
  /// these are omitted and counted here, so that the loop never lags behind.
  std::int64_t missed = 0;
  bool had_priority = false;
  std::vector<ServoSample> samples; ///< of every tick
};

/// Reads a device, runs a tick of the probe and writes the force, at the probe's period. Elastic answers are
/// computed in other threads (see ContactPhysics).
///
/// Memory is allocated before the loop starts. On Linux the thread sleeps to an absolute time with a timer
/// slack of a microsecond, and uses real-time priority if permitted.
class ServoLoop {
public:
  /// Starts the loop. @param device, probe must outlive the loop, and are used only by it until it has ended
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

/// World of a probe: fixed and rigid objects in one map, the surfaces of deformable ones at rest, and the
/// solvers for their stiffness. Only the tool of the probe moves.
class ProbedWorld {
public:
  /// @param tool number of the rigid object that is the tool; -1: a point with the voxel of one cell
  /// @param radius of the footprint, see ContactSolver [m]
  /// @throws std::invalid_argument for overlapping objects, deformable ones in other than three dimensions, a
  ///         tool that is not rigid
  ProbedWorld(const WorldScene& scene, int tool, double radius);
  /// A single deformable body without walls, from the scene's body, materials, limits and holds. The tool is
  /// a point.
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
  std::unique_ptr<RigidShape> tool_; ///< at a fixed address: solvers refer to it
  std::optional<Pose> start_;
};

} // namespace maille::deform
