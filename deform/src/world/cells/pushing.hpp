#pragma once
/// Contact by cells between movable objects: an object pushes the objects in its way.
///
/// A *rigid object* moves until its first contact. A free rigid object in its way is shifted by the rest of
/// the movement; a body receives requests to move its nodes out of all cells on the way. The object then
/// continues until an obstacle does not move.
///
/// A *body* settles with all other objects fixed (Settling). Each pinned node then requests its remaining
/// movement (`rest`) from the object in its way: a node of a body becomes a pin with a prescribed place
/// there, a rigid object receives a shift. The receiver settles in turn and may push further. If forces are
/// known, may_push() lets the side with the larger pressure push by a cell at a time, until the pressures
/// cannot be made more equal.
///
/// Always feasible. Heuristic: the order of receivers, and the limits on pushes that end the exchange.

#include "world/cells/settling.hpp"

#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

namespace maille::deform {

/// Effect of earlier pushes on the faces between two objects along an axis.
struct PushEffect {
  double change = 0; ///< of the imbalance of pressures by one push, estimated [N]
  /// The imbalance before the last push of this step, towards the object with the higher number [N]
  std::optional<double> before{};
  int n = 0; ///< pushes in this step
};
/// Keys: the objects' numbers, the lower first, and the axis.
using PushEffects = std::map<std::tuple<int, int, int>, PushEffect>;

class Pushing {
public:
  Pushing(FrameRun& frame, PushEffects& effects);
  virtual ~Pushing() = default;

  /// Moves a rigid object and the objects that it pushes. @return the part of the motion that was done
  virtual double push_rigid(int object, RigidMotion motion, bool slides);
  /// Settles bodies until none moves.
  void come_to_rest();
  /// Bodies and rigid objects that are not at rest.
  std::set<int> unsettled;

protected:
  FrameRun& frame_;
  WorldObjects& world_;

private:
  /// A movement that one object requests from another.
  struct Request {
    int from;
    std::int64_t from_voxel;
    double movement = 0; ///< along the pin's axis [cells]; for a rigid object [m]
  };
  struct PinRequest {
    Pin pin;
    Request by;
  };
  using PinRequests = std::map<int, std::vector<PinRequest>>; ///< by object
  /// Movements that a body requests from other bodies and from free rigid objects, by object and axis.
  struct Requests {
    PinRequests pins;
    std::map<std::pair<int, int>, Request> shifts;
  };
  /// All faces through which one body presses on another object along an axis.
  struct Faces {
    int other, axis, direction;
    friend auto operator<=>(const Faces&, const Faces&) = default;
  };

  bool is_movable(int object) const;
  std::vector<std::pair<int, std::size_t>> pins_on(int object) const;
  void take_along(const std::vector<std::pair<int, std::size_t>>& gripped, const Pose& from, const Pose& to);
  bool clear_cell(int object, const RigidMotion& rest, const Contact& contact);
  bool push_free_rigid(int object, const Request& shift, int axis);
  bool ask_bodies_in_the_way(int object, const RigidMotion& rest, PinRequests& asked);

  void settle(int object);
  bool push_others(int object);
  Requests requests_of(int object);
  void request(int object, const Pin& pin, int other, Requests& requests);
  static Pin pin_of(const DeformableObject& body, const DeformableObject::Carrier& carrier, int axis,
                    int direction, double to, const Index3& wall);
  static void add(std::vector<PinRequest>& list, const Pin& pin, const Request& by);
  bool ask(int object, const std::vector<PinRequest>& asked);
  bool may_push(int object, const Faces& faces, const std::vector<const Pin*>& pins);
  double pressure_back(int object, const Faces& faces) const;

  PushEffects& effects_;
  std::set<int> in_progress_; ///< objects that are pushing: they are not pushed back
};

} // namespace maille::deform
