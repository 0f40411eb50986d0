#pragma once
/// Contact of one deformable object with fixed obstacles, by an active set.
///
/// A pin is a node that is prescribed at the wall it touches. A turn solves the body with the present pins,
/// moves it towards that answer, pins the nodes that hit walls on the way, and releases pins that pull on
/// their wall. The loop ends when a turn changes nothing. The number of releases per pin is limited, so that
/// the loop terminates; if it fails, the body keeps its feasible state.
///
/// Friction is solved in an outer loop: touching nodes stick where they touched; if the walls of one side
/// together exert more than the friction bound, all their nodes slip by the same part. This is exact for the
/// sum per side, not per node.
///
/// Always feasible: moves end before the first hit. Heuristic: release counts and tolerances.

#include "world/frame_run.hpp"
#include "world/occupancy/node_cells.hpp"

#include <string>
#include <vector>

namespace maille::deform {

/// Unilateral contact by an active set: the method answers with the nodes in contact prescribed (pins). Nodes
/// that hit a wall on the way to the answer are pinned to it, pins that pull on a wall are released, and the
/// method answers again, until neither happens.
///
/// Before a body would pass through itself it stops, and the nodes of both parts are pinned where they are,
/// along the axis between the parts, until the object settles again.
///
/// **Friction** (Coulomb). Once the contacts are known, their nodes are held where they touched, and the
/// method answers again. If the tangential forces of all walls on one side together exceed the friction
/// bound, their nodes slip towards their positions without friction, by the part that reduces the force to
/// the bound.
/// If limits bind or the method has no forces (`limits`), nodes are pinned where they are at first contact,
/// so that all prescribed values belong to one feasible state; otherwise all nodes that hit a wall are pinned
/// at their faces at once.
class Settling {
public:
  /// @param friction Coulomb's coefficient
  Settling(OccupancyMap& map, DeformableObject& body, double friction, FrameClock& clock)
      : map_(map), body_(body), friction_(friction), clock_(clock) {}

  /// @return true if it has settled; the state is always feasible. `message()` gives the reason if a method
  ///         had no answer
  bool run();
  const std::string& message() const { return message_; }
  /// True if a node is pinned to a wall that is no longer there.
  bool has_stale_walls() const;

private:
  enum class Turn { again, settled, given_up };
  Turn turn();
  bool run_without_friction();
  bool run_with_friction();
  bool apply_friction_bound();
  bool apply_friction_bound(int axis, int direction);
  void begin();
  void clip_to_limits();
  bool release_pulling_pins();
  bool release_stale_pins();
  bool has_no_wall(const Pin& pin) const;
  double meet(const std::vector<Hit>& hits, const Displacement& to);
  void pin_touching(const std::vector<Hit>& hits, double part);
  bool pin_at_faces(const std::vector<Hit>& hits);
  void add_contact(const Hit& hit, bool at_face);
  double meet_itself(const std::vector<SelfHit>& hits, const Displacement& to);
  Pin pin_of(const Hit& hit) const;
  int& changes_of(const Pin& pin) { return changes_[3 * pin.voxel + pin.axis]; }

  OccupancyMap& map_;
  DeformableObject& body_;
  double friction_;
  FrameClock& clock_;
  bool touches_only_ = false;
  std::vector<int> changes_;  ///< releases of the pin of a node along an axis, since begin()
  double largest_before_ = 0; ///< pressure in the answer before the last [N]
  std::string message_;
};

} // namespace maille::deform
