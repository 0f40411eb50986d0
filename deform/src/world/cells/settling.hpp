#pragma once
/// Contact of one deformable object with obstacles that stand still, by an active set.
///
/// A pin is a node prescribed at the wall that it touches. A turn solves the body with the present pins,
/// moves towards that answer, pins the nodes that hit walls on the way, and releases pins whose wall would
/// have to pull. It ends when a turn changes nothing. A pin may be released a limited number of times, so the
/// loop terminates; otherwise the body keeps its feasible state.
///
/// Friction is solved in an outer loop: touching nodes are held where they touched; if the walls of one side
/// together pull by more than friction allows, all their nodes slip by the same share. This is exact for the
/// sum per side, not per node.
///
/// Feasible at any time: moves end before the first hit. Heuristic: release counts and tolerances.

#include "world/frame_run.hpp"
#include "world/occupancy/node_cells.hpp"

#include <string>
#include <vector>

namespace maille::deform {

/// Unilateral contact by an active set: the method answers with the nodes in contact prescribed (pins); nodes
/// that hit a wall on the way to the answer are pinned to it, those that a wall would have to pull are let
/// go, and the method answers again, until neither happens.
///
/// Where a body would pass through itself it goes on to just before that, and the nodes of both parts are
/// pinned where they are, along the axis across which they meet, until the object is settled again.
///
/// **Friction** (Coulomb). Once the nodes in contact are known, they are held where they touched, and the
/// method answers again. Where the walls on one side then pull along themselves by more than friction allows,
/// taken together, their nodes slip towards where they would be without friction, by the part that brings the
/// force down to that.
/// Where limits bind or nothing else is known (`limits`), nodes are pinned where they are when they first
/// touch, so that all prescribed values are those of one feasible state; else all that hit something are
/// pinned at their faces at once.
class Settling {
public:
  /// @param friction Coulomb's coefficient
  Settling(OccupancyMap& map, DeformableObject& body, double friction, FrameClock& clock)
      : map_(map), body_(body), friction_(friction), clock_(clock) {}

  /// @return whether it has settled; the state is feasible in any case. `message()` says why a method had no
  ///         answer
  bool run();
  const std::string& message() const { return message_; }
  /// True if a node is pinned to a wall that has moved away.
  bool has_walls_that_are_gone() const;

private:
  enum class Turn { again, settled, given_up };
  Turn turn();
  bool run_without_friction();
  bool run_with_friction();
  bool let_slip();
  bool let_slip(int axis, int direction);
  void begin();
  void clip_to_limits();
  bool let_go_of_pulled();
  bool forget_walls_that_are_gone();
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
  std::vector<int> changes_;  ///< of the pin of a node along an axis, since it began
  double largest_before_ = 0; ///< pressure, by the answer before the last [N]
  std::string message_;
};

} // namespace maille::deform
