#pragma once
/// What moves the objects of a world: one law of contact behind one interface.
///
/// A World is a scene and one engine. The engine owns the objects (WorldObjects: rigid ones in the map,
/// bodies with their displacements) and advances them a frame at a time. Whenever advance() returns, the
/// state is feasible: no object is inside another, and limits that bind are kept.
///
///   OpenBody       one body alone, without a map
///   CellEngine     cells/     a cell of the map belongs to one object; bodies answer by their method
///   SurfaceEngine  balance/   surfaces touch; a frame ends where all forces are in balance
///   ImpactEngine   dynamics/  the same with masses, rigid objects alone: free flight and impacts
///   InertiaEngine  dynamics/  the same with masses and bodies: implicit steps in time
///
/// The loops of 1995 implement it too, as oracles (tests/support/worlds). A new law of contact is one class,
/// its line in engine_for(), and an instantiation of tests/deform/world/engines_test.cpp.
///
/// The defaults below serve every engine whose objects are those of WorldObjects; OpenBody has its own.

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
  /// @throws std::invalid_argument for drives that do not fit; nothing has moved then
  virtual FrameResult advance(std::span<const Drive> drives, const FrameBudget& budget) = 0;
  virtual void release(int object);
  /// Sets up what the first frame would have to wait for.
  virtual void prepare(const FrameBudget&) {}
  virtual bool is_settled() const;
  /// The present state, independent of this one; null where the engine cannot copy itself.
  virtual std::unique_ptr<Engine> copy() const { return nullptr; }

  virtual const Pose& pose(int object) const;
  virtual const Displacement& displacement(int object) const { return world_->body(object).displacement(); }
  /// The same, to be kept while frames go on.
  virtual std::shared_ptr<const Displacement> shared_displacement(int object) const;
  /// A node of a deformable object, in the world [m].
  virtual Eigen::Vector3d position(int object, std::int64_t node) const;
  virtual ObjectMotion motion(int) const { return {}; }
  virtual double energy() const { return 0; }
  /// The body with everything that is prescribed to it now.
  virtual Scene question(int object) const { return world_->body(object).question(); }
  virtual double largest_violation() const;
  virtual std::int64_t bytes() const;

private:
  std::unique_ptr<WorldObjects> world_; ///< at one place: parts of engines refer to it
};

/// The engine of a scene's law of contact.
/// @throws std::invalid_argument as World::World
std::unique_ptr<Engine> engine_for(WorldScene scene);

} // namespace maille::deform
