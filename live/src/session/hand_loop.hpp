#pragma once
/// Hand loop at 1 kHz: reads the device, moves the goal, keeps the proxy free of overlap, outputs the force.

#include "session/physics.hpp"

namespace maille::live {

/// Request of the window to the hand; the newest one is used.
struct HandWish {
  std::uint64_t number = 0;
  std::uint64_t grip_number = 0; ///< 0: no object is held
  bool is_rigid = false;         ///< the held object is rigid
  deform::Pose pose;
  double event_time = 0;
  int axis = -1; ///< see HandGoal
};

class HandLoop {
public:
  HandLoop(Physics& physics, const SessionSettings& settings);
  ~HandLoop();

  /// For the window's thread only.
  void wish(const HandWish& wish);
  void use(std::shared_ptr<HandDevice> device);
  /// For any thread.
  struct Felt {
    std::uint64_t grip_number = 0;
    deform::Pose goal;
    std::optional<deform::Pose> proxy;
    Eigen::Vector3d force = Eigen::Vector3d::Zero();
    DeviceState device;
    bool is_moved_by_device = false; ///< the device has moved the goal since the last wish
    double event_time = 0;           ///< time of the last event that the proxy includes
  };
  Felt felt() const;
  HandReport report() const;
  /// True if the newest wish has been passed to the physics.
  bool is_idle() const { return wishes_ == wishes_done_; }

private:
  void run();
  void tick();
  void take_wish();
  void take_surroundings();
  void move_goal(const DeviceState& device);
  void move_proxy();
  void show_force();

  Physics* physics_;
  double stiffness_, largest_force_;
  deform::TripleBuffer<HandWish> wish_;
  std::atomic<std::uint64_t> wishes_{0}, wishes_done_{0};
  std::atomic<std::shared_ptr<HandDevice>> device_;
  std::atomic<std::uint32_t> bell_{0};
  std::atomic<bool> is_stopping_{false};

  // For the loop's thread only.
  HandWish now_;
  HandGoal goal_;
  DeviceState device_now_;
  std::optional<deform::Pose> device_before_;
  bool is_moved_by_device_ = false;
  std::int64_t proxy_pause_ = 0; ///< ticks until the next proxy step: the proxy uses at most half of the time
  std::shared_ptr<const HandSurroundings> around_;
  std::optional<deform::Proxy> proxy_;
  double proxy_time_ = 0; ///< time of the last event included
  deform::Pose sent_;
  std::uint64_t sent_grip_ = 0;
  double sent_time_ = 0;
  Eigen::Vector3d force_ = Eigen::Vector3d::Zero();

  mutable std::mutex felt_lock_; ///< locked only while copying
  Felt felt_;
  HandReport report_;
  std::thread thread_;
};

} // namespace maille::live
