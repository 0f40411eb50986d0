#pragma once
/// Contact by cells: a cell of the map belongs to at most one object.
///
/// A frame divides all drives into steps in which no driven point moves further than a cell. In a step each
/// drive moves its object: a rigid one along its motion or by the spring of a drive, a deformable one by new
/// handle positions. Objects in the way are pushed (Pushing), then all bodies settle (Settling) until none
/// moves. A frame also ends when its budget is exhausted; the state is always feasible.
///
/// Exact: no voxel enters an occupied cell. Heuristic: the order of bodies, and the limits on pushes and
/// rounds.

#include "world/cells/pushing.hpp"

namespace maille::deform {

class CellEngine : public Engine {
public:
  explicit CellEngine(std::unique_ptr<WorldObjects> world) : Engine(std::move(world)) {}

  FrameResult advance(std::span<const Drive> drives, const FrameBudget& budget) override;
  std::unique_ptr<Engine> copy() const override;

protected:
  /// Runs all steps of a frame and writes its result.
  void move(FrameRun& frame, Pushing& pushing);

  PushEffects effects_;
};

} // namespace maille::deform
