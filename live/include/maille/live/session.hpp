#pragma once
/// Interactive session with a world: three loops that never wait for each other.

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
  std::uint64_t scene_number = 0; ///< changes with the scene, see Session::scene
  std::int64_t frame = 0, n_frames = 0;
  std::vector<deform::Pose> frames; ///< of the objects' frames; deformable objects: frame of the scene
  std::vector<std::shared_ptr<const Displacement>> displacements; ///< null for fixed and rigid objects
  Status status = Status::done;
  std::string message;                                  ///< of the last frame, or an error
  double frame_seconds = 0;                             ///< duration of the last frame
  double violation = 0;                                 ///< see World::largest_violation
  Eigen::Vector3d hand_force = Eigen::Vector3d::Zero(); ///< force needed by the hand [N]
  bool knows_forces = false, is_settled = true, is_busy = false;
  /// Estimates of the last frame: see FrameResult [m], [N].
  std::optional<double> motion_left, force_left;
  double event_time = 0; ///< time of the last event included [s]; 0: none
  std::shared_ptr<const std::vector<std::int64_t>> held_nodes;
  int held_object = -1;
};

/// Objects or nodes that the hand holds.
struct Grip {
  int object = -1;
  std::vector<std::int64_t> nodes; ///< of a deformable object; the first node follows the goal
};

/// Target pose of the held object: of its frame if it is rigid; for nodes, the position of the first one and
/// a rotation about it.
struct HandGoal {
  std::uint64_t grip_number = 0;
  deform::Pose pose;
  double event_time = 0;
  int axis = -1; ///< world axis that constrains a rigid object, without sliding along obstacles. -1: none
};

/// Time budget of a frame of bodies with forces [s].
inline constexpr double usual_budget = 0.022;

struct SessionSettings {
  int threads = 1;
  std::optional<std::filesystem::path> record;
  /// Time budget [s]; 0: until settled. Unset: usual_budget for bodies with forces, else until settled.
  std::optional<double> frame_budget;
  std::vector<WorldSetting> settings;
  double coupling_stiffness = 300; ///< between hand and object, for haptic devices [N/m]
  double largest_force = 3.3;      ///< limit of the force sent to a device [N]
};

struct HandReport {
  deform::LatencyHistogram latency; ///< from the due time of a tick to its end
  std::int64_t ticks = 0, missed = 0;
  bool had_priority = false;
};

class Physics;
class HandLoop;

/// Hand loop at 1 kHz: reads the device, keeps the proxy of the held object out of other objects, outputs the
/// force. Physics loop: moves the world towards the newest goal, frame by frame, and publishes its state. The
/// caller renders the picture: state() never waits for either loop.
class Session {
public:
  /// @throws std::invalid_argument if objects share cells (see World); std::runtime_error if the record
  ///         cannot be written; InputError for settings that the world does not support
  Session(WorldScene scene, const SessionSettings& settings);
  /// Ends both loops; the record is complete.
  ~Session();

  std::shared_ptr<const WorldState> state() const;
  /// The present scene with its settings; belongs to a state's `scene_number`.
  std::shared_ptr<const WorldScene> scene() const;
  /// Sets the function that the physics thread calls for each new state.
  void on_state(std::function<void()> call);

  // Requests of the hand. These functions return immediately.
  void grip(Grip grip, double event_time);
  /// @param goal its `grip_number` is ignored
  void reach(const deform::Pose& goal, double event_time, int axis = -1);
  /// Releases the held object: nodes stay fixed in place (pinned) or move freely again.
  void let_go(bool keep_pinned, double event_time);
  void release_all(double event_time);
  bool is_holding() const;
  /// The newest goal.
  deform::Pose goal() const;
  /// Pose of the proxy of a held rigid object; nothing without a held rigid object or a proxy.
  std::optional<deform::Pose> proxy() const;
  /// Time of the last event that the proxy has followed [s]; 0 before the first. If read before proxy(), it
  /// is no later.
  double proxy_event_time() const;
  /// Force that the 1 kHz loop sends to the hand [N].
  Eigen::Vector3d felt() const;
  /// Buttons of the device, one bit each; 0 without a device.
  std::uint32_t device_buttons() const;
  /// True if a device is connected.
  bool has_device() const;
  /// Selects the device that moves the held object; null: the mouse.
  void use(std::shared_ptr<HandDevice> device);

  void undo();
  void redo();
  void go_to(std::int64_t frame);
  void change(const WorldSetting& setting);
  void set_frame_budget(std::optional<double> seconds);
  /// True if all requests have been processed.
  bool is_idle() const;
  /// Waits until is_idle(), at most `seconds`. @return is_idle()
  bool wait_idle(double seconds);

  HandReport hand_report() const;
  /// The trajectory so far.
  std::string text() const;
  /// Scene of a deformable object in its present state, for error estimates; taken between two frames.
  std::shared_ptr<const Scene> question(int object) const;
  /// Number of voxels inside other objects, recomputed: see World. Always 0.
  std::int64_t n_penetrations() const;

private:
  void open_hand();
  /// Goes to another moment.
  void travel(std::function<void(Timeline&, const deform::FrameBudget&)> go);

  std::unique_ptr<Physics> physics_;
  std::unique_ptr<HandLoop> hand_;
  // For the window's thread only.
  std::uint64_t grip_number_ = 0, is_open_ = 0; ///< grip number of the open hand
  deform::Pose wish_;
  int axis_ = -1; ///< axis of the wish
};

} // namespace maille::live
