#pragma once
/// Physics loop: moves the world frame by frame towards the goal of the hand, and sleeps when idle.

#include "maille/live/session.hpp"

#include <Eigen/Geometry>

#include <deque>

namespace maille::live {

bool has_soft_bodies(const WorldScene& scene);

/// Obstacles of a held rigid object, for the 1 kHz loop: immutable.
struct HandSurroundings {
  std::uint64_t grip_number = 0;
  deform::ToolSurroundings others;
  std::shared_ptr<const deform::RigidShape> tool;
  deform::Pose lattice; ///< pose of the tool in the physics: free of overlap
  deform::Pose frame;   ///< pose of the object at that time
};

class Physics {
public:
  Physics(WorldScene scene, const SessionSettings& settings);
  ~Physics();

  std::shared_ptr<const WorldState> state() const { return state_.load(); }
  std::shared_ptr<const WorldScene> scene() const { return scene_.load(); }
  void on_state(std::function<void()> call);

  /// Queues a command; commands run between two frames, in order.
  using Command = std::function<void()>;
  void post(Command command);
  /// Sets the newest goal. For the hand thread only.
  void set_goal(const HandGoal& goal);
  /// Newest obstacles; null if unchanged. For the hand thread only.
  const HandSurroundings* new_surroundings();

  void take_grip(Grip grip, std::uint64_t number, double event_time);
  void let_go(bool keep_pinned, const HandGoal& last, double event_time);
  void release_all(double event_time);
  Timeline& timeline() { return timeline_; }
  const Timeline& timeline() const { return timeline_; }
  void prepare() { timeline_.prepare(budget()); }
  void set_budget(std::optional<double> seconds) { budget_seconds_ = seconds; }
  /// See SessionSettings::frame_budget.
  deform::FrameBudget budget() const;
  /// Budget of a world with changed settings.
  deform::FrameBudget budget_by(const WorldSetting& changed) const;
  /// True if all goals up to number `goals` are processed and no work remains.
  bool is_idle(std::uint64_t goals) const;
  std::uint64_t n_goals() const { return goals_set_.load(); }
  void publish(bool is_busy);
  void say(std::string message) { message_ = std::move(message); }
  /// Registers a changed scene; releases the held object.
  void renew_scene();
  /// Resets the hand after undo, redo or go_to; releases the held object.
  void renew_state();
  std::int64_t scene_number() const { return scene_number_; }

private:
  void run();
  /// @return true if there were commands
  bool do_commands();
  bool go_on();
  bool move_towards_goal();
  std::vector<DriveSpan> spans_to_goal();
  std::vector<DriveSpan> spans_of_rigid();
  std::vector<DriveSpan> spans_of_nodes();
  DriveSpan span_along_axis(const deform::Pose& now, const Eigen::AngleAxisd& turn);
  std::vector<DriveSpan> spans_of_rest() const;
  double longest_step() const;
  void publish_surroundings();
  std::shared_ptr<const HandSurroundings> surround() const;
  void keep_result(const deform::FrameResult& result);
  bool is_stuck() const;
  void take_note();
  /// Publishes the last state again, with the present state of the hand.
  void publish_again();

  Timeline timeline_;
  std::optional<double> budget_seconds_;
  int threads_;
  std::atomic<std::shared_ptr<const WorldState>> state_;
  std::atomic<std::shared_ptr<const WorldScene>> scene_;
  std::uint64_t scene_number_ = 0;
  std::mutex commands_lock_;
  std::deque<Command> commands_;
  std::function<void()> on_state_;
  deform::TripleBuffer<HandGoal> goal_;
  deform::TripleBuffer<std::shared_ptr<const HandSurroundings>> surroundings_;

  // For the physics thread only.
  Grip grip_;
  std::uint64_t grip_number_ = 0;
  std::vector<Eigen::Vector3d> grip_offsets_; ///< of held nodes from the first one, at grip time [m]
  HandGoal goal_now_;
  bool has_goal_ = false;
  /// Goal that the last frames could not approach any further.
  std::optional<deform::Pose> vain_goal_;
  double event_time_ = 0;
  deform::FrameResult last_;
  std::string message_;
  Eigen::Vector3d hand_force_ = Eigen::Vector3d::Zero();
  double violation_ = 0;
  int n_settling_ = 0, n_in_vain_ = 0;
  bool has_surroundings_ = false;
  bool turns_ = false; ///< the last frame rotated the axis-constrained object

  std::atomic<std::uint32_t> bell_{0};
  std::atomic<std::uint64_t> goals_set_{0}, goals_done_{0};
  std::atomic<std::int64_t> commands_left_{0};
  std::atomic<bool> is_resting_{false}, is_stopping_{false};
  std::uint64_t state_number_ = 0;
  std::thread thread_;
};

} // namespace maille::live
