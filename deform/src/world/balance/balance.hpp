#pragma once
/// Contact between surfaces: the state of least energy of all objects in contact.
///
/// Unknowns: displacements of deformable objects (linear elasticity in the object's frame), and rigid motions
/// of movable objects. Constraint: no node of a skin is inside another skin. A Touch is a node near another
/// skin, with gap g, normal n and force f >= 0.
///
/// A round linearises. It finds the touches with their gaps and normals, and assembles the compliance W of
/// all touches from columns of each body's Flexibility and from the rigid motions. The contact program solves
/// g + W f >= 0, f >= 0, f g = 0 (with friction: friction_program). All objects then move towards that
/// solution by at most a fifth of a cell. Rounds repeat until nothing moves; rounds with the same contacts
/// are mixed.
/// SurfaceObject holds the data of one object (RigidPart, SoftPart). Balance: balance.cpp sets up objects,
/// drives and results; touches.cpp finds touches; balanced_contacts.cpp solves the contact program;
/// rounds.cpp moves objects. surface_engine.cpp runs the rounds of a frame; dynamics/ uses the same objects
/// with inertia.
/// Exact: balance and gaps of the last round. Heuristic: step lengths, the drag on free objects (which
/// vanishes at rest), and locality (bodies move only near touches until catch_up()).

#include "world/balance/surface_object.hpp"
#include "world/surface/friction_program.hpp"

#include <Eigen/Core>

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

namespace maille::deform {

/// Contact distance: closer surfaces touch, and surfaces in contact keep this distance [cells].
inline constexpr double skin_over_cell = 1e-4;

/// Largest motion of any point in a round or a time step [cells]. Longer steps miss edges; shorter ones take
/// more rounds.
inline constexpr double round_over_cell = 0.2;

class ConvexCell;

/// A node of an object's skin that is near another skin or near the border of the world.
struct Touch {
  int object = 0, other = -1;
  std::int32_t node = 0;                             ///< of the object's skin
  std::array<std::int32_t, 4> nodes{-1, -1, -1, -1}; ///< of the other object's skin
  std::array<double, 4> weights{};
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< from the other skin to the node
  double gap = 0;                                    ///< [m]
  double force = 0;                                  ///< along the normal, on the node [N]
  Eigen::Vector3d rubbing = Eigen::Vector3d::Zero(); ///< friction on the node [N]
};

/// All objects of a world with `contact = "surfaces"`.
///
/// **Local**: as long as no body is moving towards the values of its handles, rounds move only nodes near
/// other surfaces. No contact depends on the other nodes meanwhile. catch_up() moves them after the rounds,
/// or when the near nodes have moved so far that new pairs may be near.
class Balance {
public:
  /// @throws std::invalid_argument naming an object that cannot be carried
  explicit Balance(WorldObjects& world);

  const std::vector<SurfaceObject>& objects() const { return objects_; }
  SurfaceObject& object(int number) { return objects_[number]; }
  const SurfaceObject& object(int number) const { return objects_[number]; }
  const std::vector<Touch>& touches() const { return touches_; }
  double cell() const { return cell_; }
  /// Updates which objects and nodes are driven. To be called after handles or drives change.
  void hold(int threads);
  /// Updates the displacements of bodies without contacts from the values of the handles.
  void prescribe();
  /// Finds all touches in the present state.
  void find_touches();
  /// Moves all nodes of all bodies to their response to the contact forces.
  void catch_up();
  /// Begins a drive step: present contacts stick at their present places.
  void begin();
  /// Runs a round. Steps become shorter while rounds alternate: then a node is on an edge between faces, and
  /// its forces are shares of the forces on these faces. @return largest motion of any point [m]
  double round();
  /// Motion since the last search for touches [m].
  double gone() const { return motion_since_search_; }
  /// Estimated remaining change until convergence, extrapolated from the last rounds.
  struct Left {
    double motion = 0; ///< largest remaining motion of any point [m]
    double force = 0;  ///< largest remaining change of the force on an object [N]
  };
  Left left() const;
  /// Active contacts, with the forces that balance the present state.
  const std::vector<Touch>& pressing() const { return pressing_; }
  /// A pair of overlapping objects, also if no corner of one is inside the other.
  std::optional<std::pair<int, int>> crossing();
  /// The part of the state that rounds change.
  struct State;
  State state() const;
  void restore(const State& state);
  /// Writes poses and displacements to the world, and marks its occupancy map as outdated.
  void hand_back();
  /// Duration of the last call [s].
  double seconds_to_hand_back() const { return seconds_to_hand_back_; }
  /// Force of a drive on a handle of a body, in the body's initial frame [N].
  Vec3 pull_at(int object, std::int64_t node) const;

private:
  /// A force on one node of an object, for 1 N of a contact.
  struct Push {
    int row, object;
    Eigen::Vector3d force, at;    ///< in the world
    std::int64_t first_component; ///< of the node of a body; -1: rigid
  };
  struct Program {
    std::vector<std::vector<Push>> pushes; ///< by object
    Eigen::MatrixXd compliance;
    Eigen::VectorXd gap;
    std::vector<char> may_pull, active;
    std::vector<FrictionRows> rubs;                       ///< contacts with friction
    std::vector<std::array<Eigen::Vector3d, 2>> tangents; ///< of the contacts in `rubs`
  };
  /// A border of the world that nodes of an object are near.
  struct NearBorder {
    int object, axis;
    std::vector<std::int32_t> nodes;
  };
  void look_around();
  void watch();
  bool is_local() const { return distance_to_unloaded_ == 0; }
  void measure_touches();
  void add_touches(int object, int other, std::span<const NearFaces::OfNode> nodes);
  std::vector<ConvexCell> cells_near(int object, int other);
  void add_border(const NearBorder& border);
  /// Place where friction holds a contact on the other's skin, or in the world.
  struct Grip {
    std::array<std::int32_t, 4> nodes{-1, -1, -1, -1};
    std::array<double, 4> weights{};
    Eigen::Vector3d place = Eigen::Vector3d::Zero(); ///< of the border [m]
  };
  using Key = std::tuple<int, int, std::int32_t>; ///< object, other, node
  static Key key_of(const Touch& touch) { return {touch.object, touch.other, touch.node}; }
  Grip grip_at(const Touch& touch) const;
  Eigen::Vector3d place_of(const Touch& touch, const Grip& grip) const;
  void push_apart(const Touch& touch, const Eigen::Vector3d& along, int row, Program& program) const;
  /// Rows of all touches, pulled components and friction, without the compliance.
  Program program() const;
  Program part_of(const Program& whole, const std::vector<char>& is_chosen);
  Eigen::VectorXd gaps_after(const Program& program, const std::vector<Response>& responses) const;
  void add_friction(Program& program, std::vector<double>& gap) const;
  void add_compliance_of_body(int object, Program& program);
  void add_compliance_as_a_whole(int object, Program& program) const;
  Response response(int object, const Program& program, const Eigen::VectorXd& force);
  void grip();
  /// Solves the contact program and returns every object's motion and forces.
  std::vector<Response> responses();
  void set_drag();
  void stop_drifts(std::vector<Response>& responses);
  /// Largest motion of a full step [m].
  double furthest(const std::vector<Response>& responses) const;
  void remember(double furthest, double not_done);
  double dot_with_last_step(const std::vector<Response>& responses);
  /// Mixes the responses with those of earlier rounds. @return remaining motion [m]; nothing if the responses
  /// did not change
  std::optional<double> mix(std::vector<Response>& responses, double furthest);
  void share_forces(double part);
  /// Error of a pulled component at its prescribed value [m].
  double missed(int object, std::int64_t component) const;

  WorldObjects& world_;
  int threads_ = 1;
  std::vector<SurfaceObject> objects_;
  double cell_ = 0;      ///< least spacing of all objects [m]
  double stiffness_ = 1; ///< of a cell of the stiffest body [N/m]
  std::vector<Touch> touches_, pressing_;
  std::map<std::pair<int, int>, NearFaces> near_faces_; ///< of objects whose boxes have met
  /// Pairs of objects that are near now, and nodes of the first near the second where either can move.
  std::vector<std::tuple<int, int, std::vector<NearFaces::OfNode>>> near_pairs_;
  std::vector<NearBorder> near_borders_;
  bool has_looked_ = false;        ///< near_pairs_ and near_borders_ are up to date
  double motion_since_search_ = 0; ///< upper bound of the motion since then [m]
  /// Largest distance of bodies from `unloaded`, apart from contacts [m].
  double distance_to_unloaded_ = 0;
  double length_ = 1;                   ///< step length as a part of the full step
  double drag_ = 1;                     ///< factor on the drag on free objects
  int rounds_ = 0;                      ///< since begin()
  std::array<double, 4> asked_{};       ///< largest motion of full steps, the last round first [m]
  double not_done_ = 0;                 ///< part of the last full step that was not done
  std::vector<Eigen::Vector3d> forces_; ///< sum of contact forces on each object, in the last full step [N]
  double force_change_ = 0;             ///< largest change of these in the last round [N]
  /// Motions of rounds with the same contacts, and the responses of these rounds; shifts and rotations are
  /// counted from the first.
  std::vector<std::pair<Eigen::VectorXd, std::vector<Response>>> past_;
  bool has_stalled_ = false; ///< mixing no longer reduces the motion
  std::vector<Key> pressed_; ///< active contacts of the last round
  std::map<Key, Grip> grips_;
  double seconds_to_hand_back_ = 0;
};

struct Balance::State {
  struct Object {
    Pose pose;
    std::optional<Pose> target;
    std::optional<SoftPart::State> soft;
  };
  std::vector<Object> objects;
  std::vector<Touch> touches, pressing;
  std::map<Key, Grip> grips;
  double behind = 0;
};

} // namespace maille::deform
