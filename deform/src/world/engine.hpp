#pragma once
/// The interface of engines, which move the objects of a world by one contact law.
///
/// A World is a scene and one engine. The engine owns the objects (WorldObjects: rigid ones in the map,
/// bodies with their displacements) and advances them frame by frame. After every advance() the state is
/// feasible: no object is inside another, and binding limits are satisfied.
///
///   OpenBody       a single body, without a map
///   CellEngine     cells/     a cell of the map belongs to one object; bodies follow their method
///   SurfaceEngine  balance/   surface contact; a frame ends in equilibrium
///   ImpactEngine   dynamics/  the same with masses, rigid objects only: free flight and impacts
///   InertiaEngine  dynamics/  the same with masses and bodies: implicit time steps
///
/// The loops of 1995 implement it too, as references for tests (tests/support/worlds). A new contact law
/// needs one class, its line in engine_for(), and an instantiation of tests/deform/world/engines_test.cpp.
///
/// The defaults below are for engines that store their objects in WorldObjects; OpenBody has its own.

#include "world/world_objects.hpp"

#include <memory>
#include <span>
#include <utility>

namespace maille::deform {

class Engine {
public:
  explicit Engine(std::unique_ptr<WorldObjects> world) : world_(std::move(world)) {}
  virtual ~Engine() = default;
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  WorldObjects& world() { return *world_; }
  const WorldObjects& world() const { return *world_; }

  /// One frame, as World::advance.
  /// @throws std::invalid_argument for invalid drives; no object has moved then
  virtual FrameResult advance(std::span<const Drive> drives, const FrameBudget& budget) = 0;
  virtual void release(int object);
  /// Makes the set-up that the first frame would otherwise wait for.
  virtual void prepare(const FrameBudget&) {}
  virtual bool is_settled() const;
  /// An independent copy of the present state; null if the engine cannot copy itself.
  virtual std::unique_ptr<Engine> copy() const { return nullptr; }

  virtual const Pose& pose(int object) const;
  virtual const Displacement& displacement(int object) const { return world_->body(object).displacement(); }
  /// The same, with shared ownership across frames.
  virtual std::shared_ptr<const Displacement> shared_displacement(int object) const;
  /// A node of a deformable object, in the world [m].
  virtual Eigen::Vector3d position(int object, std::int64_t node) const;
  virtual ObjectMotion motion(int) const { return {}; }
  virtual double energy() const { return 0; }
  /// The body with all its present prescribed values.
  virtual Scene question(int object) const { return world_->body(object).question(); }
  virtual double largest_violation() const;
  virtual std::int64_t bytes() const;

private:
  std::unique_ptr<WorldObjects> world_; ///< at a fixed address: parts of engines refer to it
};

/// The engine for a scene's contact law.
/// @throws std::invalid_argument as World::World
std::unique_ptr<Engine> engine_for(WorldScene scene);

} // namespace maille::deform
