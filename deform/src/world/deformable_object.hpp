#pragma once
/// One deformable object of a world: its state, and the answers of its method for holds, handles and
/// contacts.

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

/// Contact constraint: one component of a node, prescribed at a face of the map; all components if the object
/// is rotated.
struct Pin {
  std::int32_t voxel = 0;
  int axis = 0;      ///< of the face, in the world
  int direction = 1; ///< from the node to the wall: -1 or 1
  /// Displacement in the object's frame [m]. If the object is not rotated only `axis` is used, and the other
  /// components if friction holds the node.
  Vec3 at{};
  double rest = 0;     ///< remaining movement along the axis, signed [cells]
  double pressure = 0; ///< on the wall, from the last answer [N]; negative: it pulls
  /// Displacements without friction, and with all nodes held by friction, in the object's frame [m].
  Vec3 free{}, stuck{};
  double hold = 1;       ///< its place, as a part of the way from `free` to `stuck`
  Vec3 grip{};           ///< tangential force of the wall, from the last answer, object's frame [N]
  bool is_asked = false; ///< a movement requested by another object, without a wall yet
  /// The wall of a point of the surface near the node; unset: the cell adjacent to the node's own.
  std::optional<Index3> wall{};
  bool stays = false; ///< for the rest of the frame, with or without its wall: see Settling
  /// The blocking node of the same body, in self-contact.
  std::optional<std::int32_t> self{};
};

class DeformableObject;
class KeptAnswers;

/// The cell that a pinned node presses on.
Index3 wall_of(const DeformableObject& body, const Pin& pin);

/// Scene of the object's body with its holds only, for its method.
/// @throws std::invalid_argument if the method does not support it
std::unique_ptr<Scene> checked_scene(const WorldObject& object, const WorldScene& world);

class DeformableObject {
public:
  /// @throws std::invalid_argument if the method does not support it
  DeformableObject(const WorldObject& object, const Pose& pose, const WorldScene& world, VoxelId first);
  DeformableObject(DeformableObject&&) noexcept;
  /// Copies the state without the cache for the next answer.
  DeformableObject(const DeformableObject& other);
  ~DeformableObject();

  const Scene& scene() const { return *scene_; }
  const PosedLattice& lattice() const { return lattice_; }
  NodeCells& cells() { return cells_; }
  const NodeCells& cells() const { return cells_; }
  const BodyMatter& matter() const { return matter_; }
  const SelfContact& self_contact() const { return self_contact_; }
  /// Adds points to the faces that are stretched now or in another state (see BodyMatter::watch).
  void watch(const Displacement& to) { matter_.watch(lattice_, state_, to); }
  /// Puts the matter into the map, once; go_towards() then updates it.
  void put_matter(OccupancyMap& map) { matter_.put(map, cells_.first(), lattice_.places(state_)); }
  /// Puts any state into a map without this object; cells of other objects stay theirs.
  void put_at(OccupancyMap& map, const Displacement& state) {
    set_state(state);
    put_into(map);
  }
  void set_state(const Displacement& state) { state_ = state; } ///< without the map
  void put_into(OccupancyMap& map);
  /// Stiffness of a cell of its stiffest material [N/m].
  double cell_stiffness() const { return stiffness_; }
  /// The first number after the object's own.
  VoxelId end_of_ids() const { return cells_.first() + cells_.n_ids(); }

  /// A node that must move to free a cell.
  struct Carrier {
    std::int32_t voxel;
    double place;    ///< coordinate along the axis of the matter in the cell [cells]
    bool is_between; ///< matter between nodes, not the node itself
  };
  /// Carriers of the object's matter in one of its own cells: the nodes there, or the corners of the cell of
  /// matter there.
  std::vector<Carrier> carriers(const OccupancyMap& map, const Index3& cell, int axis) const;
  const Displacement& displacement() const { return state_; }
  bool knows_forces() const { return method_ == "relaxed" || method_ == "coupled"; }
  /// Replacement for drag_limits, for the method `limits`.
  using ByLimits = Answer (*)(const Scene&, const LinkLimits&, const Displacement& state, const Control&);
  void set_by_limits(ByLimits rule) { by_limits_ = rule; }
  bool limits_bind() const { return limits_bind_; }
  /// Limits of its links, active or not.
  const LinkLimits& limits() const { return limits_; }
  /// Sets whether friction holds nodes in contact: their other components are then prescribed too, unless
  /// they already are.
  void set_wall_friction(bool do_grip) { walls_grip_ = do_grip; }

  /// A driven node.
  struct Handle {
    Vec3 at{};              ///< requested displacement [m]
    bool is_driven = false; ///< in this step; else it is held in place
    Vec3 force{};           ///< of the drive, from the last answer, object's frame [N]
  };
  std::map<std::int64_t, Handle>& handles() { return handles_; }
  const std::map<std::int64_t, Handle>& handles() const { return handles_; }
  std::vector<Pin>& pins() { return pins_; }
  const std::vector<Pin>& pins() const { return pins_; }
  /// Adds a pin, or replaces the pin of the same node and axis.
  void add_pin(const Pin& pin);

  /// Removes pins of nodes that are not at their pins, so that the present state meets the rest.
  void keep_reached_pins();
  /// Reduces requests (asked pins) to the least ones that satisfy the limits together: each moves as far as
  /// requested, or as far as the others push it.
  void reconcile_requests();

  /// The method's answer, starting from the present state. Pressures of pins and forces of handles are those
  /// of this answer, if the method has forces.
  Answer answer(const Control& control);
  /// The body with all its present prescribed values: holds, handles at their places, contacts.
  Scene question() const;
  /// True if holds, kept handles and all pins are compatible with the limits.
  bool can_be_met() const;
  /// Moves to a convex combination of the state and another: by `part` or, if rounding would put a node into
  /// a cell of another object, slightly less. @return the part
  double go_towards(OccupancyMap& map, const Displacement& to, double part);
  /// Sets the handles to the present displacements of their nodes.
  void settle_handles();
  double largest_violation() const;
  /// Solver error of a force [N], estimated from that of a rigid shift by the largest displacement. Smaller
  /// forces are noise.
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

  std::unique_ptr<Scene> scene_; ///< with holds only; limits point to its specimen
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
  std::unique_ptr<KeptAnswers> kept_; ///< of `coupled`, cached between frames
  std::map<std::int64_t, Handle> handles_;
  std::vector<Pin> pins_;
};

} // namespace maille::deform
