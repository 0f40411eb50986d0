#pragma once
/// Fixed, rigid and deformable objects in one occupancy map, moved frame by frame.
///
/// A frame takes drives (the motions of hands) and a budget, and ends in a feasible state: no object inside
/// another, links within their limits. The scene's contact law selects the engine: cells (voxels pass pushes
/// on), surfaces (elastic bodies in contact), or surfaces with masses (dynamics). Cells are exact in float64;
/// surfaces are converged to the scene's tolerance. The same drives give the same bits.

#include "maille/deform/world/rigid_world.hpp"
#include "maille/scene/answer.hpp"
#include "maille/scene/world/world_scene.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace maille::deform {

/// Prescribed motion of an object in one frame.
struct Drive {
  int object = 0; ///< rigid or deformable
  /// Motion of the whole object, or of the nodes below, in the world.
  RigidMotion motion;
  /// Driven nodes of a deformable object (numbers of its grid, nodes of the body), each listed once. They
  /// become handles: they keep their place until they are driven again or released. Empty for a rigid object.
  std::vector<std::int64_t> nodes;
  /// True: a blocked rigid object slides along its obstacle, without the rotation.
  bool slides = false;
  /// A hand that leads a rigid object by a spring: `motion` moves the hand, and the object follows as near as
  /// obstacles allow.
  struct Lead {
    Pose hand;              ///< pose of the hand before the motion, as a pose of the object
    double stiffness = 300; ///< [N/m], > 0
  };
  std::optional<Lead> lead{};
};

/// Budget of a frame; the state is feasible at any end.
struct FrameBudget {
  std::optional<double> seconds; ///< unset: until settled
  std::optional<std::int64_t>
      rounds; ///< answers of the method, over all objects; unset: 300 per step of a cell
  std::function<bool()> stop_requested; ///< polled between rounds, and by the method
  int threads = 1;
  double frame_seconds = 1.0 / 30; ///< simulated time of the frame, with dynamics [s], > 0
};

/// Motion of an object in a world with dynamics; for 1 m of thickness in two dimensions.
struct ObjectMotion {
  double mass = 0;                                    ///< [kg]
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero(); ///< of the centre of mass [m/s]
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();     ///< [rad/s]
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();   ///< of mass, in the world [m]
};

/// Contact of a voxel with an obstacle at the end of a frame.
struct WorldContact {
  int object = 0;
  std::int64_t voxel = 0; ///< of the object: a node of its grid, or a voxel of its shape
  int other = -1;         ///< object; -1: the border of the world
  std::int64_t other_voxel = 0;
  int axis = 0;      ///< of the face between them
  int direction = 1; ///< from the voxel to the other along that axis: -1 or 1
  /// Force of the other object on the voxel, in the world [N] (per metre of thickness in 2D); zero if the
  /// method has no forces. With surface contact each contact is listed from both sides.
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  std::optional<Eigen::Vector3d> at{}; ///< place of a surface contact [m]
};

/// A movement that one voxel could not make and passed on to the one in its way. asked = moved + refused,
/// where `refused` may have been passed on in turn.
struct HandOver {
  int from = 0;
  std::int64_t from_voxel = 0;
  int to = -1; ///< object; -1: the border of the world
  std::int64_t to_voxel = 0;
  int axis = 0;
  double asked = 0; ///< along the axis, signed [m]
  double moved = 0; ///< part that the receiver moved [m]
  double refused() const { return asked - moved; }
};

/// Result of one drive.
struct DriveResult {
  /// Finished fraction of the motion: of the time for a rigid object, of the path (mean over nodes) for
  /// nodes.
  double fraction = 0;
  Eigen::Vector3d force = Eigen::Vector3d::
      Zero(); ///< required force of the hand, in the world [N]; zero if the method has no forces
};

struct FrameResult {
  /// done: settled, and all drives were completed; clamped: settled, but a wall, a hold or the limits
  /// shortened a drive; budget_reached, interrupted: a feasible intermediate state.
  Status status = Status::done;
  std::string message; ///< reason if not done; else empty
  double seconds = 0;
  std::int64_t rounds = 0;
  /// Remaining motion of any point until convergence [m], and remaining change of the force on any object
  /// [N], extrapolated from the last rounds: estimates, no bounds. 0: converged. Known for surface contact
  /// without dynamics.
  std::optional<double> motion_left, force_left;
  std::vector<DriveResult> drives; ///< as given
  std::vector<WorldContact> contacts;
  std::vector<HandOver> handed_on; ///< in order
};

class Engine;

/// The voxel world, quasi-static: a frame ends at rest, or when its budget is exhausted.
///
/// Voxels of fixed and rigid objects are the centres of their cells, those of deformable objects the nodes. A
/// cell of the world always belongs to at most one object. Blocked objects pass their movement on to the
/// object in their way. Bodies stay feasible between answers of their methods, so that a frame may end at any
/// time. Coulomb friction acts only if the method has forces. An object without holds, which `coupled` cannot
/// solve, follows by `limits` or, if its limits do not bind, by `relaxed`. docs/contact.md describes the
/// rules and their exceptions.
///
/// Units       metres and newtons, in the world's axes unless stated otherwise
/// Repeatable  same bits for any number of threads, unless a budget of seconds ends a frame
/// Source      Gibson 1995, "Object deformation". Departures: the rest of a movement is passed on within the
///             limits of both bodies, instead of one voxel after the other; answers of a method replace the
///             relaxation of single voxels
/// Checked by  tests/deform/world/world_test.cpp and its neighbours, tests/cross_check/contact_test.cpp
class World {
public:
  /// @throws std::invalid_argument with the name of the object, if objects share a cell or leave the world,
  ///         if numbers do not match (dimension, spacing, method), or if a deformable object has moves, loads
  ///         or contracting fibres
  explicit World(WorldScene scene);
  /// Moved by an engine of the caller, such as the loops of 1995 in studies/lab.
  explicit World(std::unique_ptr<Engine> engine);
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;
  ~World();

  /// Moves driven objects as far as possible and settles the others.
  /// @throws std::invalid_argument for a drive of a fixed object, of nodes outside the body, or with values
  ///         that are not finite
  FrameResult advance(std::span<const Drive> drives, const FrameBudget& budget = {});
  /// Releases an object: handles of a deformable one become free, a rigid one may be pushed again.
  void release(int object);
  /// Makes the set-up that the first frame of an open world's elastic body would otherwise wait for. Moves no
  /// object.
  void prepare(const FrameBudget& budget = {});
  /// True if a frame without drives would change nothing: no frame has ended before rest, and no object with
  /// forces was released since.
  bool is_settled() const;
  /// A copy of the world: the same drives give both the same bits, for `coupled` the same to its tolerance.
  /// Nothing for an open world that moves by `limits`, and with surface contact.
  std::optional<World> copy() const;
  /// The body of a deformable object with all its present prescribed values: holds, handles at their places,
  /// contacts. The state of the object is its method's answer to that.
  Scene question(int object) const;

  const WorldScene& scene() const;
  /// With surface contact, the first call after a frame adds the bodies to the map: not thread-safe then.
  const OccupancyMap& map() const;
  const Vec3& cell_size() const;
  int n_objects() const;
  ObjectKind kind(int object) const;

  /// @pre the object is fixed or rigid
  const RigidShape& shape(int object) const;
  /// Frame of an object; constant for a deformable object.
  const Pose& pose(int object) const;
  /// Motion in a world with dynamics; otherwise zero.
  ObjectMotion motion(int object) const;
  /// Energy of the free objects in a world with dynamics: kinetic, and potential above the world's corner
  /// [J].
  double energy() const;
  /// Displacement of a deformable object, in its own frame [m].
  const Displacement& displacement(int object) const;
  /// The present displacement, with shared ownership across frames. Not copied for the body of an open world.
  std::shared_ptr<const Displacement> shared_displacement(int object) const;
  /// Position of a node of a deformable object, in the world [m]. @pre a node of the body
  Eigen::Vector3d position(int object, std::int64_t node) const;

  /// Part of an object's matter that is thinner than a cell of the world: not covered by any box of the size
  /// of a cell, along the object's axes, inside the matter. Contact treats it as a cell thick, so that
  /// objects on its two sides stay at that distance.
  double thin_part(int object) const;

  struct Occupant {
    int object = 0;
    std::int64_t voxel = 0; ///< a node of its grid, or a voxel of its shape
  };
  /// Object and voxel of a number in the map.
  Occupant occupant(VoxelId id) const;

  /// Contacts of the voxels' boxes of a rigid object within `reach` [cells], besides those of their middles
  /// (see RigidWorld::touched).
  std::vector<WorldContact> touched(int object, double reach) const;

  /// Number of cells of matter that are inside another object, or outside the border, by more than half the
  /// diagonal of a cell of the world. Found from geometry (boxes, cells of matter with displaced corners),
  /// without the map. A cell counts if its middle, or one of its points half a diagonal inside its faces, as
  /// dense as cells of the world, and 26 points at that distance around it are in the other's matter.
  /// Cost  only objects with intersecting bounding boxes are tested
  std::int64_t n_penetrations() const;
  /// Number of voxels in a cell of another object or outside the world, recomputed from positions without the
  /// map. Always 0.
  std::int64_t n_shared_cells() const;
  /// Largest violation of binding limits (given, or the material's own) by a link of a deformable object,
  /// over its length.
  double largest_violation() const;

  std::int64_t bytes() const;

private:
  std::unique_ptr<Engine> engine_;
};

} // namespace maille::deform
