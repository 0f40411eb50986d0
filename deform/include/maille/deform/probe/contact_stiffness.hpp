#pragma once
/// How stiff a body is where a probe presses it: by `coupled`, beside the loop that feels it.

#include "maille/deform/probe/body_surface.hpp"
#include "maille/deform/probe/triple_buffer.hpp"

#include <atomic>
#include <memory>
#include <thread>

namespace maille::deform {

/// Where a probe presses, as its loop says it.
struct ContactSite {
  std::int64_t number = 0;                         ///< of what was asked, rising; 0: nothing yet
  std::int32_t face = -1;                          ///< of the body's surface
  Eigen::Vector3d point = Eigen::Vector3d::Zero(); ///< in the world [m]
  double depth = 0;                                ///< that the body is to give way by, > 0 [m]
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

/// Answers contact sites, one after the other and always the newest, by `coupled`: the surface's nodes near the point go with the probe,
/// along the face's normal at rest alone (there is no friction), and the lattice's reaction against that over the depth is the stiffness.
/// Holds stay; a node that is held along that normal is left out; where none is left the body is rigid there.
///
/// A single node of a lattice stands for an area of a cell: its stiffness falls with the spacing, as that of a point does in the continuum.
/// A footprint of several cells has a stiffness of its own.
///
/// Where the scene asks for limits that bind (not taut ones), the stiffness is the secant at the depth, and a site is asked anew when
/// its depth has changed by a fourth; elsewhere it does not depend on the depth.
///
/// Checked by  tests/deform/probe/contact_stiffness_test.cpp
class ContactSolver {
public:
  /// @param scene of three dimensions with holds; must outlive the solver @param surface of it at rest
  /// @param radius of the footprint about the point, in the body's frame at rest [m]; at least the nearest node is pressed
  /// @throws std::invalid_argument for another dimension, moves, loads or contracting fibres, a radius below 0
  ContactSolver(const Scene& scene, std::shared_ptr<const BodySurface> surface, double radius);

  /// Before anything is solved: a rigid flat disk of the footprint's radius, at least half a spacing, on a half space of the materials'
  /// mean: 2 a E / (1 - nu^2) (Sneddon 1965).
  ContactStiffness estimate() const;
  /// @return status as of solve_coupled; where that has no answer, the estimate
  ContactStiffness solve(const ContactSite& site, const Control& control = {}) const;
  /// The whole answer, with the displacement of all nodes [m]. Refused where every node of the footprint is held.
  Answer press(const ContactSite& site, const Control& control = {}) const;

  bool depends_on_depth() const { return scene_->limits_bind_coupled(); }
  const BodySurface& surface() const { return *surface_; }
  /// Nodes that are pressed there, rising. @pre a face of the surface
  std::vector<std::int64_t> footprint(const ContactSite& site) const;

private:
  /// The scene with the footprint moved by the depth. @return how many nodes it moves
  int add_moves(const ContactSite& site, Scene& scene) const;

  const Scene* scene_;
  std::shared_ptr<const BodySurface> surface_;
  double radius_;
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

} // namespace maille::deform
