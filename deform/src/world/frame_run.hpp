#pragma once
/// One frame of a world: what all engines share.
///
/// A frame takes drives and a budget. FrameRun checks the drives before anything moves, knows where driven
/// nodes were, counts rounds and time (FrameClock), and writes into the result what became of the drives.
/// Engines cut the drives into n_steps() steps, in which nothing driven moves further than a cell.

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
  std::function<std::optional<double>()> seconds_left; ///< unset in the answer: as many as it takes
  std::int64_t rounds = 0;                             ///< done
  std::optional<Status> ended;                         ///< why nothing more may be done

  /// True if budget remains; otherwise sets `ended`.
  bool may_go_on();
  void count_round();
};

/// The part of a motion from time `begin` to `end`, as a motion of its own.
RigidMotion part_of(const RigidMotion& motion, double begin, double end);

/// Image of a point under a motion.
Eigen::Vector3d moved_point(const RigidMotion& motion, const Eigen::Vector3d& point);

/// The axis and direction of a contact that are nearest to its normal, which points at contact.object.
void set_axis(WorldContact& contact, const Eigen::Vector3d& normal);

class FrameRun {
public:
  /// @throws std::invalid_argument for a drive that does not fit
  FrameRun(Engine& engine, std::span<const Drive> drives, const FrameBudget& budget);
  FrameRun(const FrameRun&) = delete;
  FrameRun& operator=(const FrameRun&) = delete;

  /// Steps in which nothing driven moves further than a cell along any axis.
  int n_steps() const;
  /// After these a drive has crossed the whole world in any direction: the rest of its way leads out.
  int most_steps() const { return 8 * (world.scene.cells[0] + world.scene.cells[1] + world.scene.cells[2]); }
  /// Fractions of all drives; of rigid objects from `done`.
  void report_drives();
  /// Force of the spring that leads a rigid object. The fraction counts as long as the lag behind the hand
  /// does not grow.
  void report_lead(std::size_t drive);
  /// Rounds, status, message and seconds. @param endless said where contacts came and went without end
  /// @param cut_short said where the clock ended the frame
  void report_end(bool has_settled, const char* endless, const char* cut_short);

  Engine& engine;
  WorldObjects& world;
  std::span<const Drive> drives;
  std::optional<double> seconds; ///< that the frame may take
  double duration;               ///< of the frame, where the world has dynamics [s]
  FrameClock clock;
  FrameResult result;
  std::vector<double> done;                               ///< by drive of a rigid object: part of its motion
  std::vector<std::vector<Eigen::Vector3d>> nodes_before; ///< by drive: where its nodes were [m]
  std::string went_back; ///< why the frame ended at an earlier state; empty: it did not

  double seconds_so_far() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

private:
  /// Message for the first drive that was cut short; empty if none was.
  std::string first_cut_drive() const;

  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

} // namespace maille::deform
