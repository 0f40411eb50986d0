#pragma once
/// A probe in a world: its force at every tick.

#include "maille/deform/probe/device.hpp"
#include "maille/deform/probe/touch.hpp"

#include <Eigen/Core>
#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

namespace maille::deform {

/// A double buffer, and a third place between its two so that the writer need not wait until the reader has
/// looked: the writer fills one place, the reader reads another, and the newest whole one lies between them.
/// What the reader never took is overwritten.
///
/// One writer, one reader. Places are never made nor freed; what they hold (memory, counted pointers) is let
/// go by the writer, when it fills them again.
template<class T>
class TripleBuffer {
public:
  TripleBuffer() = default;
  explicit TripleBuffer(const T& value) : places_{value, value, value} {}

  /// The writer's: to be filled wholly, as it holds something older.
  T& back() { return places_[back_]; }
  /// The writer's: what is in back() is now the newest.
  void publish() { back_ = middle_.exchange(back_ | fresh, std::memory_order_acq_rel) & index; }
  void publish(const T& value) {
    back() = value;
    publish();
  }

  /// The reader's: takes the newest. @return whether there was something newer
  bool update() {
    if ((middle_.load(std::memory_order_relaxed) & fresh) == 0)
      return false;
    front_ = middle_.exchange(front_, std::memory_order_acq_rel) & index;
    return true;
  }
  /// The reader's: what it took last.
  const T& front() const { return places_[front_]; }

private:
  static constexpr std::uint32_t index = 3, fresh = index + 1;
  static_assert(std::atomic<std::uint32_t>::is_always_lock_free);

  std::array<T, 3> places_{};
  alignas(64) std::uint32_t back_ = 0;
  alignas(64) std::uint32_t front_ = 1;
  alignas(64) std::atomic<std::uint32_t> middle_{2};
};

/// Where a probe presses, as its loop says it.
struct ContactSite {
  std::int64_t number = 0;                         ///< of what was asked, rising; 0: nothing yet
  std::int32_t face = -1;                          ///< of the body's surface
  Eigen::Vector3d point = Eigen::Vector3d::Zero(); ///< in the world [m]
  double depth = 0;                                ///< that the body is to give way by, > 0 [m]
  std::optional<Pose> tool{}; ///< of its lattice, just before it touches; unset: the tool is a point
};

/// What the body answers.
struct ContactStiffness {
  std::int64_t number = 0;  ///< of the site that it answers; 0: an estimate, no site was answered yet
  double stiffness = 0;     ///< reaction over depth [N/m]
  double depth = 0;         ///< that was prescribed [m]
  double reaction = 0;      ///< along the face's normal at rest [N]
  int nodes = 0;            ///< pressed together
  std::int64_t answers = 0; ///< given so far
  double seconds = 0;       ///< that this one took
  double slowest = 0;       ///< the most that any so far took [s]
  Status status = Status::done;
};

/// Answers contact sites, one after the other and always the newest, by `coupled`: the surface's nodes near
/// the point, or those that a tool of several voxels comes to, go with the probe, along the face's normal at
/// rest alone (there is no friction), and the lattice's reaction against that over the depth is the
/// stiffness. Holds stay; a node that is held along that normal is left out; where none is left the body is
/// rigid there.
///
/// A single node of a lattice stands for an area of a cell: its stiffness falls with the spacing, as that of
/// a point does in the continuum. A footprint of several cells has a stiffness of its own.
///
/// Where the scene asks for limits that bind (not taut ones), the stiffness is the secant at the depth, and a
/// site is asked anew when its depth has changed by a fourth; elsewhere it does not depend on the depth.
///
/// What is set up for the body is kept from one answer to the next (Keeping::hierarchy_of_holds), by copies
/// of a solver together; answers do not depend on those before them. Of several threads one answers at a
/// time.
///
/// Checked by  tests/deform/probe/contact_stiffness_test.cpp
class ContactSolver {
public:
  /// @param scene of three dimensions with holds; must outlive the solver @param surface of it at rest
  /// @param radius of the footprint about the point, in the body's frame at rest [m]; at least the nearest
  ///        node is pressed @param tool what presses, must outlive the solver; null: a point
  /// @throws std::invalid_argument for another dimension, moves, loads or contracting fibres, a radius
  ///         below 0
  ContactSolver(const Scene& scene, std::shared_ptr<const BodySurface> surface, double radius,
                const RigidShape* tool = nullptr);

  /// Before anything is solved: a rigid flat disk of the footprint's radius, at least half a spacing, on a
  /// half space of the materials' mean: 2 a E / (1 - nu^2) (Sneddon 1965).
  ContactStiffness estimate() const;
  /// @return status as of solve_coupled; where that has no answer, the estimate
  ContactStiffness solve(const ContactSite& site, const Control& control = {}) const;

  bool depends_on_depth() const { return scene_->limits_bind_coupled(); }
  const BodySurface& surface() const { return *surface_; }
  /// Nodes that are pressed there, rising: within the radius, or those that the faces of the tool's voxels
  /// are before. @pre a face of the surface
  std::vector<std::int64_t> footprint(const ContactSite& site) const;

private:
  struct Pressed {
    std::int64_t node;
    double depth; ///< > 0 [m]
  };
  std::vector<Pressed> pressed(const ContactSite& site) const;
  std::vector<Pressed> before_tool(const ContactSite& site) const;
  std::vector<std::int64_t> within_radius(const ContactSite& site) const;
  /// The scene with the footprint moved by the depth. @return how many nodes it moves
  int add_moves(const ContactSite& site, Scene& scene) const;

  Answer answer(const Scene& scene, const Control& control) const;

  struct Kept;
  const Scene* scene_;
  std::shared_ptr<const BodySurface> surface_;
  double radius_;
  const RigidShape* tool_;
  std::shared_ptr<Kept> kept_;
};

/// A ContactSolver in a thread of its own, for one loop that asks.
class ContactPhysics {
public:
  /// @param solver must outlive it @param threads that a solve may use
  ContactPhysics(const ContactSolver& solver, int threads);
  /// Stops at the solver's next look at its control.
  ~ContactPhysics();
  ContactPhysics(const ContactPhysics&) = delete;
  ContactPhysics& operator=(const ContactPhysics&) = delete;

  // What one thread may call, the loop's; neither waits.
  void ask(const ContactSite& site) { sites_.publish(site); }
  const ContactStiffness& newest() {
    answers_.update();
    return answers_.front();
  }

private:
  void serve();

  const ContactSolver* solver_;
  int threads_;
  TripleBuffer<ContactSite> sites_;
  TripleBuffer<ContactStiffness> answers_;
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

/// A sampled, held spring and damper that a device shows to a hand.
struct CouplingSettings {
  double stiffness = 300;    ///< [N/m], > 0
  double damping = 0;        ///< [N s/m], >= 0
  double turn_stiffness = 0; ///< [N m/rad], >= 0; of tools of several voxels
};

/// The stiffest spring that stays passive, so that no energy can be drawn from it: 2 (b - B) / T, at least 0
/// [N/m].
///
/// @param device_damping of the device itself, not computed [N s/m] @param damping of the coupling [N
/// s/m], >= 0 @param period between forces [s], > 0
/// Source      Colgate and Brown 1994 (ICRA), "Factors affecting the Z-width of a haptic display": b > K
///             T / 2 + |B|, for walls of a spring and a damper with backward differences
double largest_passive_stiffness(double device_damping, double damping, double period);

/// Whether the coupling keeps to that bound, strictly.
inline bool is_passive(const CouplingSettings& coupling, double device_damping, double period) {
  return coupling.stiffness < largest_passive_stiffness(device_damping, coupling.damping, period);
}

/// The energy that has gone from the hand into the probe, tick by tick, exactly: forces are held between
/// ticks, so what a force does is its product with the distance gone.
///
/// It is at least 0 at all times where the probe is passive. The bound above is for one spring; springs that
/// change while they are pressed, as those of a body do whose stiffness becomes known, may break it. Then the
/// force gets what damping takes the excess back.
///
/// Source      Hannaford and Ryu 2002 (IEEE Trans. Robotics and Automation 18), "Time-domain passivity
///             control of haptic interfaces", equations 6 and 11. Departure: what the device's own damping
///             takes is counted, as it is what the bound relies on.
class PassivityObserver {
public:
  /// @param device_damping [N s/m] @param period [s] @param most_damping that is ever added [N s/m]
  PassivityObserver(double device_damping, double period, double most_damping)
      : device_damping_(device_damping), period_(period), most_damping_(most_damping) {}

  /// @param position of the device now [m] @param force that is to be shown from now on [N] @return the force
  ///        to show
  Eigen::Vector3d guarded(const Eigen::Vector3d& position, const Eigen::Vector3d& force);
  /// Counts only. @return the force as it is
  const Eigen::Vector3d& watched(const Eigen::Vector3d& position, const Eigen::Vector3d& force);

  double energy() const { return energy_; }             ///< from the hand into probe and device [J]
  double least_energy() const { return least_energy_; } ///< so far [J], <= 0
  double taken_back() const { return taken_back_; }     ///< by added damping [J]

private:
  double device_damping_, period_, most_damping_;
  bool has_begun_ = false;
  Eigen::Vector3d position_ = Eigen::Vector3d::Zero(), force_ = Eigen::Vector3d::Zero(),
                  velocity_ = Eigen::Vector3d::Zero();
  double added_damping_ = 0;
  double energy_ = 0, least_energy_ = 0, taken_back_ = 0;
};

/// Where the force of a deformable body comes from.
enum class ForceRule {
  /// The coupling's spring in series with the body's stiffness. The body feels softer than it is; the error
  /// grows with its stiffness.
  coupling,
  reaction, ///< the lattice's reaction itself, where that is passive; stiffer bodies as under `coupling`
};

struct ProbeSettings {
  CouplingSettings coupling;
  ForceRule rule = ForceRule::coupling;
  double period = 1e-3;    ///< between forces [s]
  double blending = 20e-3; ///< time constant in which a stiffness that has become known takes over [s]
  double easing = 50e-3;   ///< time constant in which a jump of the proxy on rigid matter is felt [s], >= 0
  double largest_force = 1000; ///< of the device [N]; more is cut off
  bool guard = true;           ///< whether what energy comes out is taken back, see PassivityObserver
};

/// What happened in one tick.
struct ProbeState {
  ProbeForce force;                                 ///< on the hand
  Eigen::Vector3d device = Eigen::Vector3d::Zero(); ///< where the hand is [m]
  Eigen::Vector3d proxy = Eigen::Vector3d::
      Zero(); ///< where the tool is to be shown: the proxy, on the face of the body as it gives way [m]
  bool is_touching = false;
  int body = -1;        ///< that is touched; -1: none
  double stiffness = 0; ///< shown of that body [N/m]
  double depth = 0;     ///< that the body gives way by [m]
};

/// The arithmetic of one tick, without clock or thread. docs/probe.md has the model.
///
/// The proxy goes to the place nearest to the device that it can come to; the force draws the device to it.
/// Bodies are met where their surface lies unpressed. The depth is shared between the coupling (K_c) and the
/// body (K, see ContactSolver): force = depth K K_c / (K + K_c), the tool is shown deeper by depth K_c / (K +
/// K_c). Where a free tool goes towards a body, K is asked for before it is there; a new K of a body that is
/// touched is blended in over the time `blending`; until the first answer it is an estimate. Damping acts
/// between device and proxy, never draws the hand into a wall, and makes no friction. Where the proxy goes
/// further in a tick than the hand, off a step of rigid cells, the rest of its way is felt over the time
/// `easing`: by a proxy that a damper holds back, so no energy comes of it. Forces above
/// `largest_force` are cut off. In two dimensions the hand's z is passed over.
///
/// Source      virtual coupling: Colgate, Stanley and Brown 1995 (IROS); contact with the stiffness of a
///             boundary solution beside the loop: James and Pai 2001 (Multibody System Dynamics 5)
/// Repeatable  same bits for the same poses and answers
/// Checked by  tests/deform/probe/probe_test.cpp
class Probe {
public:
  /// @param device_damping of the device [N s/m]
  /// @throws std::invalid_argument where the coupling is not passive (see is_passive) or a number does not
  ///         fit
  Probe(std::shared_ptr<const Surroundings> surroundings, Proxy proxy, const ProbeSettings& settings,
        double device_damping);

  /// Who tells how stiff a body is. `ask` is called with a site where it has changed, `newest` once a tick.
  struct BodyLink {
    std::function<void(const ContactSite&)> ask;
    std::function<const ContactStiffness&()> newest;
    bool depends_on_depth = false;
  };
  /// @param body number among the surroundings'
  void link(int body, BodyLink link);
  void link(int body, ContactPhysics& physics, bool depends_on_depth);

  /// The force for a pose of the device. A pose that is not finite counts as the last one.
  const ProbeState& tick(const Pose& device);

  const ProbeState& state() const { return state_; }
  const Proxy& proxy() const { return proxy_; }
  const Surroundings& surroundings() const { return *surroundings_; }
  const PassivityObserver& passivity() const { return observer_; }
  const ProbeSettings& settings() const { return settings_; }
  /// Sites that were asked about so far.
  std::int64_t n_sites() const { return n_sites_; }

private:
  struct Body {
    BodyLink link;
    double stiffness = 0;     ///< shown now [N/m]
    ContactSite site;         ///< asked about last
    bool was_touched = false; ///< at the last tick
  };

  /// Stiffness that a hand feels of a body [N/m].
  double felt(double body_stiffness) const;
  /// @param tool where its lattice is when it touches
  void ask(Body& body, const Obstacle& obstacle, double depth, const Pose& tool);
  /// Asks about the place of a body that the hand is coming to, before it is there.
  void look_ahead(const Eigen::Vector3d& way);
  /// Asks about the site of a constraint where it is a new one. @return the body's stiffness
  double update(Body& body, const Constraint& constraint);
  Eigen::Vector3d force_of_constraints();
  Eigen::Vector3d torque() const;
  /// What the hand is still to feel of the proxy's jumps [m].
  const Eigen::Vector3d& eased(const Eigen::Vector3d& hand_way, const Eigen::Vector3d& proxy_way);

  std::shared_ptr<const Surroundings> surroundings_;
  Proxy proxy_;
  ProbeSettings settings_;
  PassivityObserver observer_;
  double most_passive_ = 0; ///< stiffness [N/m]
  std::vector<Body> bodies_;
  Pose device_;
  Eigen::Vector3d spring_ = Eigen::Vector3d::Zero(); ///< from device to proxy at the last tick [m]
  Eigen::Vector3d behind_ = Eigen::Vector3d::Zero(); ///< what is felt of the proxy, from the proxy [m]
  bool was_touching_ = false;
  int ticks_to_look_ = 0; ///< until it is looked ahead again
  std::int64_t n_sites_ = 0;
  ProbeState state_;
};

} // namespace maille::deform
