#pragma once
/// What a hand feels: a proxy, bodies that give way, and a force that no energy comes from.

#include "maille/deform/probe/contact_stiffness.hpp"
#include "maille/deform/probe/device.hpp"
#include "maille/deform/probe/passivity.hpp"
#include "maille/deform/probe/proxy.hpp"

#include <functional>
#include <memory>

namespace maille::deform {

/// Where the force of a deformable body comes from.
enum class ForceRule {
  /// Of the coupling's spring in a row with the body's stiffness: the body feels softer than it is, the more
  /// the stiffer it is
  coupling,
  reaction, ///< the lattice's reaction itself, where that is passive; stiffer bodies as under `coupling`
};

struct ProbeSettings {
  CouplingSettings coupling;
  ForceRule rule = ForceRule::coupling;
  double period = 1e-3;        ///< between forces [s]
  double blending = 20e-3;     ///< time constant in which a stiffness that has become known takes over [s]
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
/// K_c). A new K is blended in over the time `blending`; until the first answer it is an estimate. Damping
/// acts between device and proxy, never draws the hand into a wall, and makes no friction. Forces above
/// `largest_force` are cut off. In two dimensions the hand's z is passed over.
///
/// Source      virtual coupling: Colgate, Stanley and Brown 1995 (IROS); contact with the stiffness of a
///             boundary solution beside the loop: James and Pai 2001 (Multibody System Dynamics 5)
/// Repeatable  same bits for the same poses and answers
/// Checked by  tests/deform/probe/probe_test.cpp
class Probe {
public:
  /// @param device_damping of the device [N s/m]
  /// @throws std::invalid_argument where the coupling is not passive (see is_passive) or a number does not fit
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
    double stiffness = 0; ///< shown now [N/m]
    ContactSite site;     ///< asked about last
  };

  /// Stiffness that a hand feels of a body [N/m].
  double felt(double body_stiffness) const;
  /// Asks about the site of a constraint where it is a new one. @return the body's stiffness
  double update(Body& body, const Constraint& constraint);
  Eigen::Vector3d force_of_constraints();
  Eigen::Vector3d torque() const;

  std::shared_ptr<const Surroundings> surroundings_;
  Proxy proxy_;
  ProbeSettings settings_;
  PassivityObserver observer_;
  double most_passive_ = 0; ///< stiffness [N/m]
  std::vector<Body> bodies_;
  Pose device_;
  Eigen::Vector3d spring_ = Eigen::Vector3d::Zero(); ///< from device to proxy at the last tick [m]
  bool was_touching_ = false;
  std::int64_t n_sites_ = 0;
  ProbeState state_;
};

} // namespace maille::deform
