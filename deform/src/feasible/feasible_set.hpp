#pragma once
/// The displacements of a scene whose links all keep their limits: moved in, projected onto, dragged
/// through.
///
/// The least and the greatest feasible values of a node are shortest paths from the prescribed ones. The
/// least movement is rest, clipped to them; the projection is the mean of the two envelopes of a state.
/// Everything here is exact: no parameter, no iteration to a tolerance.

#include "control/method.hpp"
#include "feasible/bounds/clipping.hpp"
#include "feasible/bounds/drag_engine.hpp"
#include "maille/deform/plan.hpp"

#include <memory>
#include <vector>

namespace maille::deform {

/// Two engines: closed form and scans where limits are the same for all links of a box, the tiled wavefront
/// on any other body; shortest paths where a body is too small for tiles. They give the same answers within
/// rounding (of the wavefront's quanta: see TiledBody), and the same bits for any number of threads.
///
/// Source      docs/theory.md, Theorems 1 to 6
/// Checked by  tests/deform/feasible/
class FeasibleSet {
public:
  /// Both must outlive it. @param limits of `scene`
  FeasibleSet(const Scene& scene, const LinkLimits& limits, int threads = 1);

  /// The requests of the scene, clipped: see clip().
  Clipping clip() const;
  /// The least movement from rest that brings the prescribed components to their values, clipped: the answer
  /// of `limits`. @param plan of the scene; @param clock running since the answer was asked for
  Answer solve(const Plan& plan, const Control& control, const Clock& clock) const;
  /// Projects: changes `state` to the feasible state that is nearest to it in the largest change of any
  /// component of any node. A feasible state stays as it is, within rounding, and to the bit if its numbers
  /// are dyadic. Nothing is held: holds and handles move as far as any other node.
  /// @param state finite; of the scene's grid; zero where there is no matter, also afterwards
  /// @return      the largest change [m]; by the wavefront, beyond its quanta
  /// Cost         scans: memory passed through twice per side and component, and as much scratch as one
  ///              component; shortest paths: two searches per component; wavefront: O(nodes)
  double project(Displacement& state) const;
  /// Changes `state` to a feasible one in which the prescribed components have their values: its projection,
  /// then the least change that brings the prescribed nodes to their values.
  /// @param clipped as clip() gives them
  void bring_in(const std::vector<Prescribed>& clipped, Displacement& state) const;
  /// A body at rest that is to be dragged.
  std::unique_ptr<DragEngine> drag() const;

private:
  bool is_homogeneous_box() const;
  bool is_small() const;
  void clamp_box(const std::vector<Prescribed>& clipped, Displacement& state) const;
  void solve_homogeneous(const Plan& plan, const Control& control, const Clock& clock, Answer& answer) const;
  void solve_by_wavefront(const Control& control, const Clock& clock, Answer& answer) const;

  const Scene& scene_;
  const LinkLimits& limits_;
  int threads_;
};

} // namespace maille::deform
