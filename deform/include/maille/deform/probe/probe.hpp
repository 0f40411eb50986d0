#pragma once
/// Haptic probe in a world: its force at every tick.

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

/// A lock-free triple buffer: the writer fills one place, the reader reads another, and the newest complete
/// value is in the third, so that neither waits. A value that the reader did not take is overwritten.
///
/// One writer, one reader. Places are never allocated or freed; the writer releases their contents (memory,
/// counted pointers) when it fills them again.
template<class T>
class TripleBuffer {
public:
  TripleBuffer() = default;
  explicit TripleBuffer(const T& value) : places_{value, value, value} {}

  /// Writer: the place to fill completely; it contains an older value.
  T& back() { return places_[back_]; }
  /// Writer: publishes back() as the newest value.
  void publish() { back_ = middle_.exchange(back_ | fresh, std::memory_order_acq_rel) & index; }
  void publish(const T& value) {
    back() = value;
    publish();
  }

  /// Reader: takes the newest value. @return true if there was a newer one
  bool update() {
    if ((middle_.load(std::memory_order_relaxed) & fresh) == 0)
      return false;
    front_ = middle_.exchange(front_, std::memory_order_acq_rel) & index;
    return true;
  }
  /// Reader: the value taken last.
  const T& front() const { return places_[front_]; }

private:
  static constexpr std::uint32_t index = 3, fresh = index + 1;
  static_assert(std::atomic<std::uint32_t>::is_always_lock_free);

  std::array<T, 3> places_{};
  alignas(64) std::uint32_t back_ = 0;
  alignas(64) std::uint32_t front_ = 1;
  alignas(64) std::atomic<std::uint32_t> middle_{2};
};

/// A contact site of a probe, published by its loop.
struct ContactSite {
  std::int64_t number = 0;                         ///< of the request, increasing; 0: none yet
  std::int32_t face = -1;                          ///< of the body's surface
  Eigen::Vector3d point = Eigen::Vector3d::Zero(); ///< in the world [m]
  double depth = 0;                                ///< requested indentation of the body, > 0 [m]
  std::optional<Pose> tool{}; ///< of its lattice, just before contact; unset: the tool is a point
};

/// Stiffness of a body at a contact site.
struct ContactStiffness {
  std::int64_t number = 0;  ///< of the site; 0: an estimate before the first answer
  double stiffness = 0;     ///< reaction over depth [N/m]
  double depth = 0;         ///< prescribed [m]
  double reaction = 0;      ///< along the face's normal at rest [N]
  int nodes = 0;            ///< number of pressed nodes
  std::int64_t answers = 0; ///< number of answers so far
  double seconds = 0;       ///< duration of this answer
  double slowest = 0;       ///< longest duration so far [s]
  Status status = Status::done;
};

/// Solves for the stiffness at contact sites with `coupled`, one after the other and always the newest. The
/// nodes of the surface near the point, or those that a tool of several voxels reaches, move with the probe
/// along the face's normal at rest only (without friction). The stiffness is the reaction of the lattice over
/// the depth. Holds stay; nodes that are held along that normal are not moved; if all are, the body is rigid
/// there.
///
/// A single node represents an area of a cell: its stiffness decreases with the spacing, as for a point load
/// in the continuum. A footprint of several cells has a well-defined stiffness.
///
/// If the scene has binding limits (not taut ones), the stiffness is the secant at the depth, and a site is
/// solved again when its depth has changed by a fourth; otherwise the stiffness does not depend on the depth.
///
/// Copies of a solver share the set-up for the body, which is cached between answers
/// (Keeping::hierarchy_of_holds); answers do not depend on earlier ones. Only one thread solves at a time.
///
/// Checked by  tests/deform/probe/contact_stiffness_test.cpp
class ContactSolver {
public:
  /// @param scene three-dimensional with holds; must outlive the solver @param surface of the scene at rest
  /// @param radius of the footprint around the point, in the body's frame at rest [m]; at least the nearest
  ///        node is pressed @param tool must outlive the solver; null: a point
  /// @throws std::invalid_argument for another dimension, moves, loads or contracting fibres, a radius
  ///         below 0
  ContactSolver(const Scene& scene, std::shared_ptr<const BodySurface> surface, double radius,
                const RigidShape* tool = nullptr);

  /// Estimate before the first solve: a rigid flat disk of the footprint's radius, at least half a spacing,
  /// on a half space of the mean material: 2 a E / (1 - nu^2) (Sneddon 1965).
  ContactStiffness estimate() const;
  /// @return status of solve_coupled(); without an answer, the estimate
  ContactStiffness solve(const ContactSite& site, const Control& control = {}) const;

  bool depends_on_depth() const { return scene_->limits_bind_coupled(); }
  const BodySurface& surface() const { return *surface_; }
  /// Nodes that are pressed at a site, sorted: those within the radius, or those that the tool's voxels
  /// reach. @pre a face of the surface
  std::vector<std::int64_t> footprint(const ContactSite& site) const;

private:
  struct Pressed {
    std::int64_t node;
    double depth; ///< > 0 [m]
  };
  std::vector<Pressed> pressed(const ContactSite& site) const;
  std::vector<Pressed> before_tool(const ContactSite& site) const;
  std::vector<std::int64_t> within_radius(const ContactSite& site) const;
  /// Adds moves of the footprint by the depth to a scene. @return count of moved nodes
  int add_moves(const ContactSite& site, Scene& scene) const;

  Answer answer(const Scene& scene, const Control& control) const;

  struct Kept;
  const Scene* scene_;
  std::shared_ptr<const BodySurface> surface_;
  double radius_;
  const RigidShape* tool_;
  std::shared_ptr<Kept> kept_;
};

/// Runs a ContactSolver in its own thread, for one servo loop.
class ContactPhysics {
public:
  /// @param solver must outlive this object @param threads of a solve
  ContactPhysics(const ContactSolver& solver, int threads);
  /// Stops when the solver next polls its control.
  ~ContactPhysics();
  ContactPhysics(const ContactPhysics&) = delete;
  ContactPhysics& operator=(const ContactPhysics&) = delete;

  // To be called by one thread, that of the loop; neither waits.
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

/// Sampled spring and damper with zero-order hold, which a device renders.
struct CouplingSettings {
  double stiffness = 300;    ///< [N/m], > 0
  double damping = 0;        ///< [N s/m], >= 0
  double turn_stiffness = 0; ///< [N m/rad], >= 0; for tools of several voxels
};

/// The largest passive stiffness, at which no energy can be extracted: 2 (b - B) / T, at least 0 [N/m].
///
/// @param device_damping physical damping of the device [N s/m] @param damping of the coupling [N s/m], >= 0
/// @param period between forces [s], > 0
/// Source      Colgate and Brown 1994 (ICRA), "Factors affecting the Z-width of a haptic display": b > K
///             T / 2 + |B|, for walls of a spring and a damper with backward differences
double largest_passive_stiffness(double device_damping, double damping, double period);

/// True if the coupling is strictly below that bound.
inline bool is_passive(const CouplingSettings& coupling, double device_damping, double period) {
  return coupling.stiffness < largest_passive_stiffness(device_damping, coupling.damping, period);
}

/// Energy transferred from the hand to the probe, exact at every tick: forces are constant between ticks, so
/// that their work is force times displacement.
///
/// It is never negative if the probe is passive. The bound above assumes a constant spring; springs that
/// change during contact, as when the stiffness of a body becomes known, may violate it. Additional damping
/// then dissipates the excess energy.
///
/// Source      Hannaford and Ryu 2002 (IEEE Trans. Robotics and Automation 18), "Time-domain passivity
///             control of haptic interfaces", equations 6 and 11. Departure: dissipation by the device's
///             own damping is included, because the bound relies on it.
class PassivityObserver {
public:
  /// @param device_damping [N s/m] @param period [s] @param most_damping upper bound of added damping [N s/m]
  PassivityObserver(double device_damping, double period, double most_damping)
      : device_damping_(device_damping), period_(period), most_damping_(most_damping) {}

  /// @param position present position of the device [m] @param force requested force until the next tick [N]
  /// @return the force to render
  Eigen::Vector3d guarded(const Eigen::Vector3d& position, const Eigen::Vector3d& force);
  /// Updates the energy only. @return the unchanged force
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

/// Source of the force of a deformable body.
enum class ForceRule {
  /// The coupling's spring in series with the body's stiffness. The body feels softer than it is; the error
  /// increases with its stiffness.
  coupling,
  reaction, ///< the lattice's reaction, if it is passive; stiffer bodies as with `coupling`
};

struct ProbeSettings {
  CouplingSettings coupling;
  ForceRule rule = ForceRule::coupling;
  double period = 1e-3;        ///< between forces [s]
  double blending = 20e-3;     ///< time constant of the transition to a new stiffness [s]
  double easing = 50e-3;       ///< time constant for jumps of the proxy on rigid matter [s], >= 0
  double largest_force = 1000; ///< of the device [N]; larger forces are clipped
  bool guard = true;           ///< dissipates generated energy, see PassivityObserver
};

/// Result of one tick.
struct ProbeState {
  ProbeForce force;                                 ///< on the hand
  Eigen::Vector3d device = Eigen::Vector3d::Zero(); ///< position of the device [m]
  Eigen::Vector3d proxy = Eigen::Vector3d::
      Zero(); ///< display position of the tool: the proxy, on the indented face of the body [m]
  bool is_touching = false;
  int body = -1;        ///< touched body; -1: none
  double stiffness = 0; ///< rendered stiffness of that body [N/m]
  double depth = 0;     ///< indentation of the body [m]
};

/// Force computation of one tick, without clock or thread. docs/probe.md describes the model.
///
/// The proxy moves to the reachable place nearest to the device, and the force pulls the device towards it.
/// The proxy contacts bodies at their undeformed surface. The depth is shared between the coupling (K_c) and
/// the body (K, see ContactSolver): force = depth K K_c / (K + K_c); the tool is displayed deeper by depth
/// K_c / (K + K_c). While a free tool approaches a body, K is requested in advance. A new K of a touched body
/// is blended in over the time `blending`; before the first answer it is an estimate. Damping acts between
/// device and proxy, never pulls the hand into a wall, and causes no friction. If the proxy moves further in
/// a tick than the hand, off a step of rigid cells, the excess is rendered over the time `easing`, as if a
/// damper held the proxy back, which adds no energy. Forces are clipped to `largest_force`. In two dimensions
/// the hand's z is ignored.
/// Source      virtual coupling: Colgate, Stanley and Brown 1995 (IROS); contact with the stiffness of a
///             boundary solution outside of the loop: James and Pai 2001 (Multibody System Dynamics 5)
/// Repeatable  same bits for the same poses and answers
/// Checked by  tests/deform/probe/probe_test.cpp
class Probe {
public:
  /// @param device_damping of the device [N s/m]
  /// @throws std::invalid_argument if the coupling is not passive (see is_passive) or a number is out of
  ///         range
  Probe(std::shared_ptr<const Surroundings> surroundings, Proxy proxy, const ProbeSettings& settings,
        double device_damping);

  /// Source of the stiffness of a body. `ask` is called with every new site, `newest` once a tick.
  struct BodyLink {
    std::function<void(const ContactSite&)> ask;
    std::function<const ContactStiffness&()> newest;
    bool depends_on_depth = false;
  };
  /// @param body number in the surroundings
  void link(int body, BodyLink link);
  void link(int body, ContactPhysics& physics, bool depends_on_depth);

  /// Computes the force for a pose of the device. A pose that is not finite is replaced by the last one.
  const ProbeState& tick(const Pose& device);

  const ProbeState& state() const { return state_; }
  const Proxy& proxy() const { return proxy_; }
  const Surroundings& surroundings() const { return *surroundings_; }
  const PassivityObserver& passivity() const { return observer_; }
  const ProbeSettings& settings() const { return settings_; }
  /// Number of requested sites so far.
  std::int64_t n_sites() const { return n_sites_; }

private:
  struct Body {
    BodyLink link;
    double stiffness = 0;     ///< rendered now [N/m]
    ContactSite site;         ///< last request
    bool was_touched = false; ///< at the last tick
  };

  /// Rendered stiffness of a body [N/m].
  double felt(double body_stiffness) const;
  /// @param tool pose of its lattice at contact
  void ask(Body& body, const Obstacle& obstacle, double depth, const Pose& tool);
  /// Requests the stiffness of a body ahead of contact.
  void look_ahead(const Eigen::Vector3d& way);
  /// Requests the stiffness at the site of a constraint if it is new. @return the body's stiffness
  double update(Body& body, const Constraint& constraint);
  Eigen::Vector3d force_of_constraints();
  Eigen::Vector3d torque() const;
  /// Part of the proxy's jumps that is not rendered yet [m].
  const Eigen::Vector3d& eased(const Eigen::Vector3d& hand_way, const Eigen::Vector3d& proxy_way);

  std::shared_ptr<const Surroundings> surroundings_;
  Proxy proxy_;
  ProbeSettings settings_;
  PassivityObserver observer_;
  double most_passive_ = 0; ///< stiffness [N/m]
  std::vector<Body> bodies_;
  Pose device_;
  Eigen::Vector3d spring_ = Eigen::Vector3d::Zero(); ///< from device to proxy at the last tick [m]
  Eigen::Vector3d behind_ = Eigen::Vector3d::Zero(); ///< rendered place of the proxy, relative to it [m]
  bool was_touching_ = false;
  int ticks_to_look_ = 0; ///< until the next look_ahead()
  std::int64_t n_sites_ = 0;
  ProbeState state_;
};

} // namespace maille::deform
