#pragma once
/// One frame of a world whose contact is found cell by cell, and the entry to the other laws of contact.
///
/// A frame cuts all drives into steps in which nothing driven moves further than a cell (n_steps). In a step
/// each drive moves its object: rigid ones by push_rigid(), which pushes free objects ahead; deformable ones
/// by new handle positions. Then come_to_rest() settles every unsettled body (Settling) and hands movement on
/// to the objects that it presses (hand_on), until none is unsettled. A frame also ends when FrameClock runs
/// out; the state is feasible at any time.
///
/// The members are implemented by topic: world_frame.cpp (steps, report), handing_on.cpp, rigid_pushing.cpp,
/// rigid_following.cpp, voxels/handed_frame.cpp (single voxels), balance/balanced_frame.cpp (surfaces),
/// dynamics/dynamic_frame.cpp (time). run() picks the law of contact.
///
/// Exact: no voxel enters a taken cell. Heuristic: the order of bodies, and the limits on pushes and rounds.

#include "world/balance/balance.hpp"
#include "world/first_contact.hpp"
#include "world/settling.hpp"
#include "world/voxels/single_voxels.hpp"
#include "world/world_parts.hpp"

#include <chrono>
#include <map>
#include <set>

namespace maille::deform {

/// The part of a motion from time `begin` to `end`, as a motion of its own.
RigidMotion part_of(const RigidMotion& motion, double begin, double end);

/// Image of a point under a motion.
Eigen::Vector3d moved_point(const RigidMotion& motion, const Eigen::Vector3d& point);

/// The axis and direction of a contact that are nearest to its normal, which points at contact.object.
void set_axis(WorldContact& contact, const Eigen::Vector3d& normal);

class WorldFrame {
public:
  /// @throws std::invalid_argument where a drive makes no sense; nothing has moved then
  WorldFrame(WorldParts& parts, std::span<const Drive> drives, const FrameBudget& budget);
  FrameResult run();

private:
  /// A movement that a node or an object is asked to make by another.
  struct Asked {
    int from;
    std::int64_t from_voxel;
    double movement; ///< along the pin's axis [cells]; of a rigid object [m]
  };
  struct AskedPin {
    Pin pin;
    Asked by;
  };
  using PinRequests = std::map<int, std::vector<AskedPin>>; ///< by object
  struct Shift {
    double movement = 0; ///< [m]
    Asked by{};
  };
  /// Movements that a body hands on to other bodies and to free rigid objects, by object and axis.
  struct Requests {
    PinRequests pins;
    std::map<std::pair<int, int>, Shift> shifts;
  };

  /// All faces through which one body presses on another object along an axis.
  struct Contacts {
    int other, axis, direction;
    friend auto operator<=>(const Contacts&, const Contacts&) = default;
  };

  // world_frame.cpp
  int n_steps() const;
  /// State of all objects.
  struct Moment {
    std::vector<Displacement> bodies;
    std::vector<Pose> poses;
  };
  Moment moment() const;
  bool is_as_it_was(const Moment& before) const;
  bool shifts_only() const;
  void drive(std::size_t i, int step, int n);
  void drive_nodes(const Drive& drive, const RigidMotion& part);
  void come_to_rest();
  void report();
  void report_drive(std::size_t i);
  /// Message for the first drive that was cut short; empty if none was.
  std::string first_cut_drive() const;
  /// Rounds, status, message and seconds. @param endless said where contacts came and went without end
  /// @param cut_short said where the clock ended the frame
  void report_end(bool has_settled, const char* endless, const char* cut_short);
  void report_contacts();
  std::string name(int object) const;

  // handed_frame.cpp
  FrameResult run_handed_on();
  void drive_voxels(std::size_t i, int step, int n, SingleVoxels& voxels);
  bool sweep_to_rest(SingleVoxels& voxels);
  void report_handed(const SingleVoxels::Handed& handed);

  // rigid_following.cpp
  void lead(std::size_t i, int step, int n);
  void report_lead(std::size_t i);

  // balanced_frame.cpp
  FrameResult run_balanced();
  /// Nodes that a hand now has.
  void take_handles();
  /// Steps of a frame that balances can follow.
  int n_balanced_steps() const;
  void drive_balanced(int step, int n);
  void put_handles(std::size_t i, double part);
  std::optional<std::pair<int, int>> goes_back(const Balance::State& before, int step, int n);
  bool is_forced_in(int object) const;
  bool take_back(int step, int n);
  bool settle_balanced(bool is_last = true);
  void find_blocked(int n);
  void report_balanced(bool has_settled);

  // dynamics/dynamic_frame.cpp
  FrameResult run_dynamic(double seconds);
  FrameResult run_soft_dynamic(double seconds);

  // rigid_pushing.cpp
  double push_rigid(int object, RigidMotion rest, bool slides);
  std::vector<std::pair<int, std::size_t>> pins_on(int object) const;
  void take_along(const std::vector<std::pair<int, std::size_t>>& gripped, const Pose& from, const Pose& to);
  bool make_way(int object, const RigidMotion& rest, const Contact& contact);
  bool push_free_rigid(int object, const Shift& shift, int axis);
  bool ask_bodies_in_the_way(int object, const RigidMotion& rest, PinRequests& asked);
  bool is_movable(int object) const;

  // handing_on.cpp
  void settle(int object);
  bool hand_on(int object);
  Requests requests_of(int object);
  void request(int object, const Pin& pin, int other, Requests& requests);
  static Pin asked_pin(const DeformableObject& body, const DeformableObject::Carrier& carrier, int axis,
                       int direction, double to, const Index3& wall);
  static void add(std::vector<AskedPin>& list, const Pin& pin, const Asked& by);
  bool ask(int object, const std::vector<AskedPin>& asked);
  bool may_push(int object, const Contacts& contacts, const std::vector<const Pin*>& pins);
  double pressure_back(int object, const Contacts& contacts) const;

  WorldParts& parts_;
  std::span<const Drive> drives_;
  FrameClock clock_;
  double frame_seconds_; ///< that the frame lasts, where the world has dynamics
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  FrameResult result_;
  std::vector<double> rigid_done_;                         ///< by drive, of its steps
  std::vector<std::vector<Eigen::Vector3d>> nodes_before_; ///< by drive
  std::set<int> unsettled_, blocked_;                      ///< blocked: drives that a rigid thing has stopped
  std::string crossed_;       ///< which surfaces a frame by surfaces went back from
  std::set<int> in_progress_; ///< bodies and rigid objects that are pushing: they are not pushed back
};

} // namespace maille::deform
