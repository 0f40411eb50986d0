#pragma once
/// Contact between surfaces: the state of least energy of all objects that touch.
///
/// Unknowns: displacements of deformable objects (linear elasticity in the object's frame) and rigid motions
/// of the objects that move as a whole. Condition: no node of a skin is inside another skin. A Touch is one
/// node near another skin, with gap g, normal n and force f >= 0.
///
/// A round linearises: touches are found, each with its gap and normal; the compliance W of all touches is
/// assembled from columns of each body's Flexibility and from the rigid motions; the contact program solves g
/// + W f >= 0, f >= 0, f g = 0 (with friction: friction_program); everything moves towards that solution, at
/// most a fifth of a cell. Rounds repeat until nothing moves; those with the same contacts are mixed.
///
/// SurfaceObject has what one object does (RigidPart, SoftPart). Balance: balance.cpp sets up objects, drives
/// and hand-back; touches.cpp finds touches; balanced_contacts.cpp solves the contact program; rounds.cpp
/// moves. surface_engine.cpp runs the rounds of a frame; dynamics/ uses the same objects with inertia.
///
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

/// Nearer surfaces touch, and surfaces in contact keep this distance [cells].
inline constexpr double skin_over_cell = 1e-4;

/// Largest motion of anything in a round, or in a step of time [cells]. Longer ones miss edges; shorter ones
/// take more rounds.
inline constexpr double round_over_cell = 0.2;

class ConvexCell;

/// A node of one object's skin that is near another skin, or near the border of the world.
struct Touch {
  int object = 0, other = -1;
  std::int32_t node = 0;                             ///< of the object's skin
  std::array<std::int32_t, 4> nodes{-1, -1, -1, -1}; ///< of the other's
  std::array<double, 4> weights{};
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< from the other to the node
  double gap = 0;                                    ///< [m]
  double force = 0;                                  ///< along the normal, on the node [N]
  Eigen::Vector3d rubbing = Eigen::Vector3d::Zero(); ///< friction on the node [N]
};

/// All objects of a world with `contact = "surfaces"`.
///
/// **Local**: where bodies are what contacts make of them (none is on its way to where handles want it),
/// rounds move only what is near something. The rest, on which nothing depends meanwhile, comes after: when
/// rounds have ended, or gone so far that something else may have come near.
class Balance {
public:
  /// @throws std::invalid_argument naming an object that cannot be carried
  explicit Balance(WorldObjects& world);

  const std::vector<SurfaceObject>& objects() const { return objects_; }
  SurfaceObject& object(int number) { return objects_[number]; }
  const SurfaceObject& object(int number) const { return objects_[number]; }
  const std::vector<Touch>& touches() const { return touches_; }
  double cell() const { return cell_; }
  /// Updates which objects and nodes are driven; to be called when handles or drives have changed.
  void hold(int threads);
  /// Puts handles' values into what bodies are without contacts.
  void prescribe();
  /// Finds all touches in the present state.
  void find_touches();
  /// Moves all of all bodies to where the forces of contacts have them. @return by how much, at most [m]
  double catch_up();
  /// A step of the hand begins: what touches now holds where it is.
  void begin();
  /// Steps get shorter where rounds go back and forth: what does not move any more then is on an edge between
  /// faces, and its forces are shares of what those ask for. @return how far anything went, at most [m]
  double round();
  /// Estimated rest until nothing moves, if rounds converge as the last ones did.
  struct Left {
    double motion = 0; ///< of anything, at most [m]
    double force = 0;  ///< by which that on any object changes, at most [N]
  };
  Left left() const;
  /// Contacts that press, with the forces that the state is in balance with.
  const std::vector<Touch>& pressing() const { return pressing_; }
  /// Two objects of which one is in the other, though no corner need be.
  std::optional<std::pair<int, int>> crossing();
  /// The part of the state that rounds change.
  struct State;
  State state() const;
  void restore(const State& state);
  /// Poses, displacements, pins' forces and the map of the world, as they are here.
  void hand_back();
  /// Duration of the last call [s].
  double seconds_to_hand_back() const { return seconds_to_hand_back_; }
  /// Force of a hand on a handle of a body, in the frame that the body had at first [N].
  Vec3 pull_at(int object, std::int64_t node) const;

private:
  /// A force on one node of an object, for 1 N of a contact.
  struct Push {
    int row, object;
    Eigen::Vector3d force, at;    ///< in the world
    std::int64_t first_component; ///< of the node, of a body
  };
  struct Program {
    std::vector<std::vector<Push>> pushes; ///< by object
    Eigen::MatrixXd compliance;
    Eigen::VectorXd gap;
    std::vector<char> may_pull, active;
    std::vector<FrictionRows> rubs;                       ///< contacts that hold, by their rows
    std::vector<std::array<Eigen::Vector3d, 2>> tangents; ///< of those
  };
  /// An end of the world that nodes of an object are near.
  struct NearBorder {
    int object, axis;
    std::vector<std::int32_t> nodes;
  };
  void look_around();
  void watch();
  bool is_local() const { return behind_ == 0; }
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
  /// All that is near, without how objects give way.
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
  void keep_free();
  void let_rest(std::vector<Response>& responses);
  /// Largest motion that a round asks for [m].
  double furthest(const std::vector<Response>& responses) const;
  void remember(double furthest, double not_done);
  double onwards(const std::vector<Response>& responses);
  /// Mixes them with those of earlier rounds. @return the motion that is missing then; nothing if they stay
  /// as they were [m]
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
  /// Two objects that are near now, and nodes of the one that are near the other where either can move.
  std::vector<std::tuple<int, int, std::vector<NearFaces::OfNode>>> near_pairs_;
  std::vector<NearBorder> near_borders_;
  bool has_looked_ = false; ///< near_pairs_ and near_borders_ are what is near
  double gone_ = 0;         ///< since then, at most [m]
  /// Largest distance of bodies from `unloaded`, apart from contacts [m].
  double behind_ = 0;
  double length_ = 1;             ///< of steps, over what rounds ask for
  double drag_ = 1;               ///< by how much more than usual free objects are held where a round begins
  int rounds_ = 0;                ///< since a step of the hand began
  std::array<double, 4> asked_{}; ///< how far anything was to go, the last round first [m]
  double not_done_ = 0;           ///< part of that
  std::vector<Eigen::Vector3d> forces_; ///< of contacts on objects, as the last round asked [N]
  double force_change_ = 0;             ///< of any of them by the last round [N]
  /// Motions of rounds with the same contacts, and the responses that these asked for; shifts and turns since
  /// the first.
  std::vector<std::pair<Eigen::VectorXd, std::vector<Response>>> past_;
  bool has_stalled_ = false; ///< mixing no longer reduces the motion
  std::vector<Key> pressed_; ///< contacts that pressed in the last round
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
