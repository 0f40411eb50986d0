#pragma once
/// A world in a hand: three loops, none of which waits for another.

#include "maille/deform/probe/servo_loop.hpp"
#include "maille/live/device.hpp"
#include "maille/live/timeline.hpp"

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace maille::live {

/// The world at one moment, for display: immutable.
struct WorldState {
  std::uint64_t number = 0;       ///< rises with every state
  std::uint64_t scene_number = 0; ///< another one: another scene, see Session::scene
  std::int64_t frame = 0, n_frames = 0;
  std::vector<deform::Pose> frames; ///< of the objects' frames; of deformable ones as the scene has them
  std::vector<std::shared_ptr<const Displacement>> displacements; ///< null of fixed and rigid objects
  Status status = Status::done;
  std::string message;                                  ///< of the last frame, or what went wrong
  double frame_seconds = 0;                             ///< that the last frame took
  double violation = 0;                                 ///< see World::largest_violation
  Eigen::Vector3d hand_force = Eigen::Vector3d::Zero(); ///< that the hand needs [N]
  bool knows_forces = false, is_settled = true, is_busy = false;
  /// Estimates of the last frame: see FrameResult [m], [N].
  std::optional<double> motion_left, force_left;
  double event_time = 0; ///< of the last event that has had its part in it [s]; 0: none
  std::shared_ptr<const std::vector<std::int64_t>> held_nodes;
  int held_object = -1;
};

/// What the hand holds.
struct Grip {
  int object = -1;
  std::vector<std::int64_t>
      nodes; ///< of a deformable object, the first is the one that goes where the goal is
};

/// Where the hand wants what it holds: of a rigid object its frame; of nodes the first one's place, turned
/// about it.
struct HandGoal {
  std::uint64_t grip_number = 0;
  deform::Pose pose;
  double event_time = 0;
  int axis = -1; ///< of the world, that a rigid object keeps to: it slides aside along nothing. -1: none
};

/// What a frame of bodies with forces may take [s].
inline constexpr double usual_budget = 0.022;

struct SessionSettings {
  int threads = 1;
  std::optional<std::filesystem::path> record;
  /// [s]; 0: until settled. Unset: likewise, but of bodies that have forces usual_budget.
  std::optional<double> frame_budget;
  std::vector<WorldSetting> settings;
  double coupling_stiffness = 300; ///< between hand and object, for devices that feel [N/m]
  double largest_force = 3.3;      ///< that is shown to a device [N]
};

struct HandReport {
  deform::LatencyHistogram latency; ///< from when a tick was due until it was done
  std::int64_t ticks = 0, missed = 0;
  bool had_priority = false;
};

class Physics;
class HandLoop;

/// The hand at 1 kHz: reads the device, keeps a proxy of what is held out of all matter, writes the force.
/// Physics: moves the world towards the newest goal, frame by frame, and publishes its state. The picture is
/// its caller's: state() never waits for either.
class Session {
public:
  /// @throws std::invalid_argument where objects share cells (see World); std::runtime_error where the record
  ///         cannot be written; InputError for settings that the world cannot have
  Session(WorldScene scene, const SessionSettings& settings);
  /// Ends both loops; what was done is in the file.
  ~Session();

  std::shared_ptr<const WorldState> state() const;
  /// The scene as it is moved now, with its settings; for a state's `scene_number`.
  std::shared_ptr<const WorldScene> scene() const;
  /// Called from the physics' thread whenever there is a new state.
  void on_state(std::function<void()> call);

  // The hand. All of them return at once.
  void grip(Grip grip, double event_time);
  /// @param goal its `grip_number` is of no account
  void reach(const deform::Pose& goal, double event_time, int axis = -1);
  /// Lets go: nodes stay where they are (pinned) or move freely again.
  void let_go(bool keep_pinned, double event_time);
  void release_all(double event_time);
  bool is_holding() const;
  /// The newest goal.
  deform::Pose goal() const;
  /// Where the proxy of a held rigid object is; nothing where none is held or it has none.
  std::optional<deform::Pose> proxy() const;
  /// Time of the last event that the proxy has followed [s]; 0 before the first. If read before proxy(), it
  /// is no later.
  double proxy_event_time() const;
  /// The force that the loop at 1 kHz shows to the hand [N].
  Eigen::Vector3d felt() const;
  /// Buttons of the device, a bit each; 0 without a device.
  std::uint32_t device_buttons() const;
  /// Whether it is there.
  bool has_device() const;
  /// From now on that device moves what is held; null: the mouse.
  void use(std::shared_ptr<HandDevice> device);

  void undo();
  void redo();
  void go_to(std::int64_t frame);
  void change(const WorldSetting& setting);
  void set_frame_budget(std::optional<double> seconds);
  /// Whether everything that was asked has been done.
  bool is_idle() const;
  /// Waits for that, at most so long. @return whether it is
  bool wait_idle(double seconds);

  HandReport hand_report() const;
  /// The trajectory so far.
  std::string text() const;
  /// Scene of a deformable object in its present state, for error estimates. Taken between two frames.
  std::shared_ptr<const Scene> question(int object) const;
  /// Voxels in the matter of others, found anew: see World. Always 0.
  std::int64_t n_penetrations() const;

private:
  void open_hand();
  /// Goes to another moment.
  void travel(std::function<void(Timeline&, const deform::FrameBudget&)> go);

  std::unique_ptr<Physics> physics_;
  std::unique_ptr<HandLoop> hand_;
  // The window's thread's own.
  std::uint64_t grip_number_ = 0, is_open_ = 0; ///< the number under which the hand is open
  deform::Pose wish_;
  int axis_ = -1; ///< of the wish
};

} // namespace maille::live
