#pragma once
/// The loop that moves the world: one frame after another towards what the hand wants, as long as there is
/// something to do.

#include "maille/live/session.hpp"

#include <Eigen/Geometry>

#include <deque>

namespace maille::live {

bool has_soft_bodies(const WorldScene& scene);

/// What a held rigid object may run into, as the loop at 1 kHz needs it: never changed.
struct HandSurroundings {
  std::uint64_t grip_number = 0;
  deform::ToolSurroundings others;
  std::shared_ptr<const deform::RigidShape> tool;
  deform::Pose lattice; ///< of the tool, as the physics has it: in no matter
  deform::Pose frame;   ///< of the object then
};

class Physics {
public:
  Physics(WorldScene scene, const SessionSettings& settings);
  ~Physics();

  std::shared_ptr<const WorldState> state() const { return state_.load(); }
  std::shared_ptr<const WorldScene> scene() const { return scene_.load(); }
  void on_state(std::function<void()> call);

  /// Done between two frames, in order.
  using Command = std::function<void()>;
  void post(Command command);
  /// One thread's, the hand's: the newest goal.
  void set_goal(const HandGoal& goal);
  /// One thread's, the hand's: what is newest of the surroundings; null where nothing has changed.
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
  /// Whether nothing is left to do for goals up to that number of theirs.
  bool is_idle(std::uint64_t goals) const;
  std::uint64_t n_goals() const { return goals_set_.load(); }
  void publish(bool is_busy);
  void say(std::string message) { message_ = std::move(message); }
  /// Another scene: what is held is let go.
  void renew_scene();
  /// Another moment of it: likewise.
  void renew_state();
  std::int64_t scene_number() const { return scene_number_; }

private:
  void run();
  /// @return whether there was something to do
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
  /// The last state, with what has become of the hand.
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

  // The physics' thread's own.
  Grip grip_;
  std::uint64_t grip_number_ = 0;
  std::vector<Eigen::Vector3d> grip_offsets_; ///< of held nodes from the first, when they were taken [m]
  HandGoal goal_now_;
  bool has_goal_ = false;
  /// The goal that the last frame went for, and that nothing has come of.
  std::optional<deform::Pose> vain_goal_;
  double event_time_ = 0;
  deform::FrameResult last_;
  std::string message_;
  Eigen::Vector3d hand_force_ = Eigen::Vector3d::Zero();
  double violation_ = 0;
  int n_settling_ = 0, n_in_vain_ = 0;
  bool has_surroundings_ = false;
  bool turns_ = false; ///< the last frame of what keeps to an axis turned it

  std::atomic<std::uint32_t> bell_{0};
  std::atomic<std::uint64_t> goals_set_{0}, goals_done_{0};
  std::atomic<std::int64_t> commands_left_{0};
  std::atomic<bool> is_resting_{false}, is_stopping_{false};
  std::uint64_t state_number_ = 0;
  std::thread thread_;
};

} // namespace maille::live
