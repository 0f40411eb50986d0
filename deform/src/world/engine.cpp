#include "world/engine.hpp"

#include "world/cells/cell_engine.hpp"
#include "world/dynamics/impact_engine.hpp"
#include "world/dynamics/inertia_engine.hpp"
#include "world/open_body.hpp"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <utility>

namespace maille::deform {

std::unique_ptr<Engine> engine_for(WorldScene scene) {
  auto world = std::make_unique<WorldObjects>(std::move(scene));
  if (world->scene.is_open)
    return std::make_unique<OpenBody>(std::move(world));
  if (world->scene.contact == ContactLaw::cells)
    return std::make_unique<CellEngine>(std::move(world));
  if (!world->scene.dynamics)
    return std::make_unique<SurfaceEngine>(std::move(world));
  if (world->bodies.empty())
    return std::make_unique<ImpactEngine>(std::move(world));
  return std::make_unique<InertiaEngine>(std::move(world));
}

void Engine::release(int object) {
  WorldObjects::Member& member = world_->member(object);
  member.is_driven = false;
  if (!world_->is_body(object))
    return;
  DeformableObject& body = world_->body(object);
  member.is_unsettled |= body.knows_forces() && !body.handles().empty();
  body.handles().clear();
}

bool Engine::is_settled() const {
  return std::ranges::none_of(world_->members, &WorldObjects::Member::is_unsettled);
}

const Pose& Engine::pose(int object) const {
  return world_->is_body(object) ? world_->body(object).lattice().pose()
                                 : world_->rigid.pose(world_->member(object).index);
}

std::shared_ptr<const Displacement> Engine::shared_displacement(int object) const {
  return std::make_shared<const Displacement>(displacement(object));
}

Eigen::Vector3d Engine::position(int object, std::int64_t node) const {
  const PosedLattice& lattice = world_->body(object).lattice();
  return lattice.position(lattice.voxel(node), displacement(object));
}

double Engine::largest_violation() const {
  double largest = 0;
  for (const DeformableObject& body : world_->bodies)
    largest = std::max(largest, body.largest_violation());
  return largest;
}

std::int64_t Engine::bytes() const {
  std::int64_t sum = world_->rigid.bytes();
  for (const DeformableObject& body : world_->bodies)
    sum += body.bytes();
  return sum;
}

} // namespace maille::deform
