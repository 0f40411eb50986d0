#pragma once
/// Fixed, rigid and deformable objects in one occupancy map, moved frame by frame.
///
/// A frame takes drives (what hands do) and a budget, and ends in a feasible state: no object inside
/// another, links within their limits. The scene's law chooses what moves the objects: cells (voxels hand
/// pushes on), surfaces (elastic bodies in contact), or surfaces with masses (dynamics). Cells are exact in
/// float64; surfaces are converged to the scene's tolerance. Same drives, same bits.

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

/// What a hand does with an object in one frame.
struct Drive {
  int object = 0; ///< rigid or deformable
  /// Motion of the whole object, or of the nodes below, in the world.
  RigidMotion motion;
  /// The driven nodes of a deformable object (numbers of its grid, nodes of the body), each listed once. They
  /// stay handles: they keep their place until they are driven again or released. Empty for a rigid object.
  std::vector<std::int64_t> nodes;
  /// Whether a rigid object goes on along what has stopped it, without the turn.
  bool slides = false;
  /// A hand that leads a rigid object by a spring: the motion is the hand's, the object comes as near to it
  /// as what is in its way lets it.
  struct Lead {
    Pose hand;              ///< where the object would be if it were where the hand is, before the motion
    double stiffness = 300; ///< [N/m], > 0
  };
  std::optional<Lead> lead{};
};

/// When a frame ends at the latest; the state is feasible whenever that is.
struct FrameBudget {
  std::optional<double> seconds; ///< unset: until settled
  std::optional<std::int64_t>
      rounds; ///< answers of the method, of all objects together; unset: 300 for each step of a cell
  std::function<bool()> stop_requested; ///< polled between rounds, and by the method
  int threads = 1;
  double frame_seconds = 1.0 / 30; ///< that the frame lasts, in a world with dynamics [s], > 0
};

/// How an object moves in a world with dynamics; of 1 m of thickness in two dimensions.
struct ObjectMotion {
  double mass = 0;                                    ///< [kg]
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero(); ///< of its centre of mass [m/s]
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();     ///< [rad/s]
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();   ///< of mass, in the world [m]
};

/// A voxel that presses against something that it cannot enter, at the end of a frame.
struct WorldContact {
  int object = 0;
  std::int64_t voxel = 0; ///< of the object: a node of its grid, or a voxel of its shape
  int other = -1;         ///< object; -1: the border of the world
  std::int64_t other_voxel = 0;
  int axis = 0;      ///< of the face between them
  int direction = 1; ///< from the voxel to the other along that axis: -1 or 1
  /// With which the other acts on the voxel, in the world [N] (per metre of thickness in 2D); zero where the
  /// method knows no forces. Where objects meet with their surfaces each contact is there from both sides.
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  std::optional<Eigen::Vector3d> at{}; ///< where surfaces meet [m]
};

/// A movement that one voxel could not make and handed on to the one in its way. asked = moved + refused,
/// where `refused` may have been handed on in its turn.
struct HandOver {
  int from = 0;
  std::int64_t from_voxel = 0;
  int to = -1; ///< object; -1: the border of the world
  std::int64_t to_voxel = 0;
  int axis = 0;
  double asked = 0; ///< along the axis, signed [m]
  double moved = 0; ///< of this, what the receiver moved [m]
  double refused() const { return asked - moved; }
};

/// What became of one drive.
struct DriveResult {
  /// Fraction of the motion that was done: of the time for a rigid object, of the path (mean over nodes)
  /// else.
  double fraction = 0;
  Eigen::Vector3d force = Eigen::Vector3d::
      Zero(); ///< that the hand needs, in the world [N]; zero where the method knows no forces
};

struct FrameResult {
  /// done: settled, and all drives were done; clamped: settled, but a drive was cut back by a wall, a hold or
  /// the limits; budget_reached, interrupted: a feasible state on the way.
  Status status = Status::done;
  std::string message; ///< why it is not done; empty if it is
  double seconds = 0;
  std::int64_t rounds = 0;
  /// How far anything would still go until all has settled [m], and how much the force on any object would
  /// still change [N], as the last rounds tell: estimates, no bounds. 0: it has settled. Known where objects
  /// meet with their surfaces, and time does not pass.
  std::optional<double> motion_left, force_left;
  std::vector<DriveResult> drives; ///< as given
  std::vector<WorldContact> contacts;
  std::vector<HandOver> handed_on; ///< in order
};

class Engine;

/// The whole voxel world, quasi-static: a frame ends where nothing wants to go on, or where its budget ends.
///
/// Voxels of fixed and rigid objects are the centres of their cells, of deformable ones the nodes. A cell of
/// the world belongs to one object at most, always. What cannot go on hands its movement on to what is in its
/// way; between answers of their methods bodies stay feasible, so a frame may end at any time. Friction
/// (Coulomb) only where the method knows forces. An object that `coupled` cannot solve because nothing holds
/// it follows by `limits`, or, where its limits do not bind, by `relaxed`. docs/contact.md has the rules, and
/// what does not hold.
///
/// Units       metres and newtons, in the world's axes unless a member says otherwise
/// Repeatable  same bits for any number of threads, unless a budget of seconds ends a frame
/// Source      Gibson 1995, "Object deformation". Departures: the rest of a movement is handed on with the
///             limits of both bodies obeyed, in place of one voxel after the other; answers of a method in
///             place of one voxel's relaxation at a time
/// Checked by  tests/deform/world/world_test.cpp and its neighbours, tests/cross_check/contact_test.cpp
class World {
public:
  /// @throws std::invalid_argument naming the object, where objects share a cell or leave the world, where
  ///         numbers do not fit (dimension, spacing, method), or where a deformable object has moves, loads
  ///         or fibres that contract
  explicit World(WorldScene scene);
  /// Moved by an engine of the caller's own, as the loops of 1995 in studies/lab are.
  explicit World(std::unique_ptr<Engine> engine);
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;
  ~World();

  /// Moves driven objects as far as they can go and settles the others.
  /// @throws std::invalid_argument for a drive of a fixed object, of nodes that are not of the body, or of
  ///         what is not finite
  FrameResult advance(std::span<const Drive> drives, const FrameBudget& budget = {});
  /// Lets go of an object: handles of a deformable one move freely again, a rigid one may be pushed again.
  void release(int object);
  /// Sets up what the first frame of an open world's elastic body would have to wait for. Nothing moves.
  void prepare(const FrameBudget& budget = {});
  /// Whether a frame without drives would change nothing: no frame has ended before all had come to rest, and
  /// nothing that has forces was let go since.
  bool is_settled() const;
  /// The world as it is, to go back to: the same drives give both the same bits, of `coupled` the same to its
  /// tolerance. Nothing for an open world that moves by `limits`, and where objects meet by surfaces.
  std::optional<World> copy() const;
  /// The body of a deformable object with everything that is prescribed to it now: its holds, handles where
  /// they have come to, contacts. Its method's answer to that is where the object is.
  Scene question(int object) const;

  const WorldScene& scene() const;
  /// Where objects meet with their surfaces, bodies are put into it when it is first asked for after a frame:
  /// not from several threads at once.
  const OccupancyMap& map() const;
  const Vec3& cell_size() const;
  int n_objects() const;
  ObjectKind kind(int object) const;

  /// @pre the object is fixed or rigid
  const RigidShape& shape(int object) const;
  /// Frame of an object; that of a deformable object never changes.
  const Pose& pose(int object) const;
  /// In a world with dynamics; else nothing moves.
  ObjectMotion motion(int object) const;
  /// Energy of the free objects in a world with dynamics: kinetic, and potential above the world's corner
  /// [J].
  double energy() const;
  /// Displacement of a deformable object, in its own frame [m].
  const Displacement& displacement(int object) const;
  /// The present displacement, to be kept while the world advances. Not copied for the body of an open world.
  std::shared_ptr<const Displacement> shared_displacement(int object) const;
  /// Where a node of a deformable object is, in the world [m]. @pre of the body
  Eigen::Vector3d position(int object, std::int64_t node) const;

  /// The part of an object's matter that is thinner than a cell of the world: that no box as large as a cell,
  /// along the object's axes, has in it. It is kept apart from others as if it were a cell thick, and what is
  /// on its two sides comes no nearer than that.
  double thin_part(int object) const;

  struct Occupant {
    int object = 0;
    std::int64_t voxel = 0; ///< a node of its grid, or a voxel of its shape
  };
  /// Who is meant by a number in the map.
  Occupant occupant(VoxelId id) const;

  /// What the voxels' boxes of a rigid object touch, within `reach` [cells], beside what their middles do
  /// (see RigidWorld::touched).
  std::vector<WorldContact> touched(int object, double reach) const;

  /// Cells of matter that are in another object, deeper than half the diagonal of a cell of the world, or as
  /// far outside its border: found by geometry (boxes, cells of matter with their corners where they are),
  /// without the map. A cell counts where its middle, or one of its points that are half a diagonal within
  /// its faces, as close as cells of the world, and 26 points at that distance round it are in the other's
  /// matter.
  /// Cost  only objects whose bounding boxes meet are looked at
  std::int64_t n_penetrations() const;
  /// Voxels that lie in a cell of another object or outside the world: found anew from positions, without the
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
