#pragma once
/// Contact cell by cell: a cell of the map belongs to one object at most.
///
/// A frame cuts all drives into steps in which nothing driven moves further than a cell. In a step each drive
/// moves its object: rigid ones along their motion or after a hand's spring, deformable ones by new handle
/// positions. Objects in the way are pushed (Pushing), then all bodies settle (Settling) until none wants to
/// move on. A frame also ends when its clock runs out; the state is feasible at any time.
///
/// Exact: no voxel enters a taken cell. Heuristic: the order of bodies, and the limits on pushes and rounds.

#include "world/cells/pushing.hpp"

namespace maille::deform {

class CellEngine : public Engine {
public:
  explicit CellEngine(std::unique_ptr<WorldObjects> world) : Engine(std::move(world)) {}

  FrameResult advance(std::span<const Drive> drives, const FrameBudget& budget) override;
  std::unique_ptr<Engine> copy() const override;

protected:
  /// All steps of a frame, and its result.
  void move(FrameRun& frame, Pushing& pushing);

  PushEffects effects_;
};

} // namespace maille::deform
