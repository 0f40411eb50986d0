#pragma once
/// One frame of a world: the part that all engines share.
///
/// A frame takes drives and a budget. FrameRun checks the drives before any object moves, stores the initial
/// places of driven nodes, counts rounds and time (FrameClock), and writes the result of the drives. Engines
/// divide the drives into n_steps() steps, in which no driven point moves further than a cell.

#include "world/engine.hpp"

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace maille::deform {

/// Remaining budget of a frame.
struct FrameClock {
  Control control; ///< of the method: threads, and when to stop
  std::optional<std::int64_t> rounds_left;
  std::function<std::optional<double>()> seconds_left; ///< unset result: unlimited
  std::int64_t rounds = 0;                             ///< done
  std::optional<Status> ended;                         ///< reason of the end, if the budget is exhausted

  /// True if budget remains; otherwise sets `ended`.
  bool has_budget();
  void count_round();
};

/// The part of a motion from time `begin` to `end`, as a motion of its own.
RigidMotion part_of(const RigidMotion& motion, double begin, double end);

/// Image of a point under a motion.
Eigen::Vector3d moved_point(const RigidMotion& motion, const Eigen::Vector3d& point);

/// Sets the axis and direction of a contact nearest to its normal, which points to contact.object.
void set_axis(WorldContact& contact, const Eigen::Vector3d& normal);

class FrameRun {
public:
  /// @throws std::invalid_argument for an invalid drive
  FrameRun(Engine& engine, std::span<const Drive> drives, const FrameBudget& budget);
  FrameRun(const FrameRun&) = delete;
  FrameRun& operator=(const FrameRun&) = delete;

  /// Number of steps in which no driven point moves further than a cell along any axis.
  int n_steps() const;
  /// Number of steps that cross the whole world in any direction: further steps lead out of it.
  int most_steps() const { return 8 * (world.scene.cells[0] + world.scene.cells[1] + world.scene.cells[2]); }
  /// Fractions of all drives; of rigid objects from `done`.
  void report_drives();
  /// Writes the force of the spring that leads a rigid object. The fraction counts while the lag behind the
  /// drive does not grow.
  void report_lead(std::size_t drive);
  /// Writes rounds, status, message and seconds. @param endless message if contacts alternate without end
  /// @param cut_short message if the clock ended the frame
  void report_end(bool has_settled, const char* endless, const char* cut_short);

  Engine& engine;
  WorldObjects& world;
  std::span<const Drive> drives;
  std::optional<double> seconds; ///< time budget of the frame
  double duration;               ///< simulated time of the frame, with dynamics [s]
  FrameClock clock;
  FrameResult result;
  std::vector<double> done;                               ///< by drive of a rigid object: part of motion done
  std::vector<std::vector<Eigen::Vector3d>> nodes_before; ///< by drive: initial places of its nodes [m]
  std::string rollback_reason; ///< reason for returning to an earlier state; empty: none

  double seconds_so_far() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

private:
  /// Message for the first drive that was cut short; empty if none was.
  std::string first_cut_drive() const;

  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

} // namespace maille::deform
