#pragma once
/// Homogeneous bodies dragged from rest into the answer's own arrays.

#include "feasible/bounds/clipping.hpp"
#include "feasible/box/separable_scans.hpp"
#include "maille/deform/plan.hpp"

namespace maille::deform {

/// Answers one scene whose plan is rest, closed form or scans for every component. Keeps no memory but one
/// row, and for scans two slabs a thread.
class RestEngine {
public:
  RestEngine(const Scene& scene, const LinkLimits& limits, const Plan& plan, int threads);

  /// Clips the scene's requests for a component, in `prescribed`.
  void clip(int component, std::vector<Prescribed>& prescribed) { clipper_.clip(component, prescribed); }
  /// Drags one component of a body at rest. @return nodes visited
  std::int64_t drag(int component, const std::vector<Prescribed>& prescribed, Displacement& state);

private:
  const Scene& scene_;
  std::array<Algorithm, 3> algorithm_;
  std::array<LinkIntervals<double>, 3> steps_;
  ThreadTeam team_;
  BoxBounds bounds_;
  Clipper clipper_;
  ClosedForm<double> closed_form_;
  SeparableScans<double> scans_;
  std::vector<HandleValue> handles_;
};

} // namespace maille::deform
