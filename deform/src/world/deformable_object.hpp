#pragma once
/// One deformable object of a world: its state, and what its method makes of holds, handles and contacts.

#include "maille/base/grid.hpp"
#include "maille/deform/world/occupancy_map.hpp"
#include "maille/scene/world/world_scene.hpp"
#include "world/occupancy/body_matter.hpp"
#include "world/occupancy/node_cells.hpp"
#include "world/occupancy/posed_lattice.hpp"
#include "world/occupancy/self_contact.hpp"

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace maille::deform {

/// One component of a node, kept on its side of a face of the map; of a turned object all of its components.
struct Pin {
  std::int32_t voxel = 0;
  int axis = 0;      ///< of the face, in the world
  int direction = 1; ///< from the node to the wall: -1 or 1
  /// Displacement in the object's frame [m]. If the object is not rotated only `axis` counts, and the others
  /// where friction keeps the node.
  Vec3 at{};
  double rest = 0; ///< of the movement that it could not make along the axis, signed [cells]
  double pressure =
      0; ///< with which it presses on the wall, by the last answer [N]; less than 0: it is pulled
  /// Places without friction, and with all nodes held by friction: displacements in the object's frame [m].
  Vec3 free{}, stuck{};
  double hold = 1;       ///< the part of the way from one to the other at which it is held
  Vec3 grip{};           ///< of the wall on the node across the axis, by the last answer, object's frame [N]
  bool is_asked = false; ///< a movement that another object asks for: there is no wall yet
  /// What a point of the surface beside the node presses on; else it is the cell beside the node's own.
  std::optional<Index3> wall{};
  bool stays = false; ///< for the rest of the frame, whether or not its wall is still there: see Settling
  /// The node of the same body that is in its way, where the body would pass through itself.
  std::optional<std::int32_t> self{};
};

class DeformableObject;
class KeptAnswers;

/// The cell that a node in contact presses on.
Index3 wall_of(const DeformableObject& body, const Pin& pin);

/// The object's body with its holds alone, as its method takes it.
/// @throws std::invalid_argument where the method cannot carry it
std::unique_ptr<Scene> checked_scene(const WorldObject& object, const WorldScene& world);

class DeformableObject {
public:
  /// @throws std::invalid_argument where the method cannot carry it
  DeformableObject(const WorldObject& object, const Pose& pose, const WorldScene& world, VoxelId first);
  DeformableObject(DeformableObject&&) noexcept;
  /// As it stands; what is kept for the next answer is not copied.
  DeformableObject(const DeformableObject& other);
  ~DeformableObject();

  const Scene& scene() const { return *scene_; }
  const PosedLattice& lattice() const { return lattice_; }
  NodeCells& cells() { return cells_; }
  const NodeCells& cells() const { return cells_; }
  const BodyMatter& matter() const { return matter_; }
  const SelfContact& self_contact() const { return self_contact_; }
  /// Follows the faces that are stretched now or would be in another state (see BodyMatter::watch).
  void watch(const Displacement& to) { matter_.watch(lattice_, state_, to); }
  /// Into the map, once; go_towards then keeps it in step.
  void put_matter(OccupancyMap& map) { matter_.put(map, cells_.first(), lattice_.places(state_)); }
  /// Into a map that has nothing of it, wherever a state is; what others have is left to them.
  void put_at(OccupancyMap& map, const Displacement& state) {
    stand_at(state);
    put_into(map);
  }
  void stand_at(const Displacement& state) { state_ = state; } ///< and is put into the map later
  void put_into(OccupancyMap& map);
  /// Stiffness of a cell of the stiffest material [N/m].
  double cell_stiffness() const { return stiffness_; }
  /// The first number after the object's own.
  VoxelId end_of_ids() const { return cells_.first() + cells_.n_ids(); }

  /// A node that is to move for a cell to be left.
  struct Carrier {
    std::int32_t voxel;
    double place;    ///< along the axis, of what lies in the cell [cells]
    bool is_between; ///< not the node itself, but matter that it carries
  };
  /// Those that carry what the object has in a cell that is its own: the nodes there, or the corners about
  /// its matter there.
  std::vector<Carrier> carriers(const OccupancyMap& map, const Index3& cell, int axis) const;
  const Displacement& displacement() const { return state_; }
  bool knows_forces() const { return method_ == "relaxed" || method_ == "coupled"; }
  /// A rule in place of drag_limits, for the method `limits`.
  using ByLimits = Answer (*)(const Scene&, const LinkLimits&, const Displacement& state, const Control&);
  void set_by_limits(ByLimits rule) { by_limits_ = rule; }
  bool limits_bind() const { return limits_bind_; }
  /// Limits of its links, active or not.
  const LinkLimits& limits() const { return limits_; }
  /// Whether friction holds nodes in contact: their other components are then prescribed too, where nothing
  /// else prescribes them.
  void let_walls_grip(bool do_grip) { walls_grip_ = do_grip; }

  /// A driven node.
  struct Handle {
    Vec3 at{};              ///< displacement that is wanted [m]
    bool is_driven = false; ///< in this step; else it is kept where it is
    Vec3 force{};           ///< of the hand, by the last answer, object's frame [N]
  };
  std::map<std::int64_t, Handle>& handles() { return handles_; }
  const std::map<std::int64_t, Handle>& handles() const { return handles_; }
  std::vector<Pin>& pins() { return pins_; }
  const std::vector<Pin>& pins() const { return pins_; }
  /// Puts a pin in the place of one of the same node and axis, if there is one.
  void add_pin(const Pin& pin);

  /// Forgets pins of nodes that are not where they are pinned to: what is left is met by the state as it is.
  void keep_reached_pins();
  /// Makes requests (asked pins) those least ones that the limits let nodes meet together: each goes as far
  /// as it was asked, or as far as the others push it.
  void reconcile_requests();

  /// The method's answer from the state as it is. Pressures of pins and forces of handles are those of this
  /// answer, where it knows any.
  Answer answer(const Control& control);
  /// The body with everything that is prescribed to it now: holds, handles where they are, contacts.
  Scene question() const;
  /// True if holds, kept handles and all pins are compatible with the limits.
  bool can_be_met() const;
  /// Goes a part of the way from the state to another, of which it is a convex mean: as far as `part` or, if
  /// rounding would put a node into a cell that is not its own, a little less. @return the part
  double go_towards(OccupancyMap& map, const Displacement& to, double part);
  /// Puts handles at where they have come to.
  void settle_handles();
  double largest_violation() const;
  /// Less than this is no force but the error of a method's algebra [N]: what a rigid shift to where the
  /// state is leaves of one.
  double force_noise() const;
  std::int64_t bytes() const;

private:
  struct Entry;
  std::vector<Entry> entries(bool pins_are_moves) const;
  void add_pin_entries(std::vector<Entry>& entries, std::size_t pin, bool is_move) const;
  Answer ask(Scene& question, const Control& control);
  void leave_where_it_is(const Scene& question, Displacement& answer) const;
  void keep_forces(const std::vector<Entry>& entries, const std::vector<double>& reaction);
  void collect_corners(const Index3& cell, std::int32_t number, int axis, std::vector<Carrier>& list) const;
  bool can_go(const OccupancyMap& map, const Displacement& to) const;

  std::unique_ptr<Scene> scene_; ///< with holds alone; limits point to its specimen
  std::unique_ptr<Scene> question_;
  std::string method_;
  double stiffness_; ///< of a cell of its stiffest material [N/m]
  bool limits_bind_;
  bool walls_grip_ = false;
  ByLimits by_limits_ = nullptr; ///< null: drag_limits
  LinkLimits limits_;
  PosedLattice lattice_;
  BodyMatter matter_;
  SelfContact self_contact_;
  NodeCells cells_;
  Displacement state_;
  std::unique_ptr<KeptAnswers> kept_; ///< of `coupled`, from one frame to the next
  std::map<std::int64_t, Handle> handles_;
  std::vector<Pin> pins_;
};

} // namespace maille::deform
