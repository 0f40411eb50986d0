/// Obstacles of a held object, collected for the 1 kHz loop.

#include "session/physics.hpp"

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace maille::live {

namespace {

/// Upper bound of tool voxels at 1 kHz; larger tools are displayed at their pose in the physics.
constexpr std::int32_t most_voxels = 1500;
/// Upper bound of the cells of a body: collecting larger surfaces takes longer than a frame. Near such a
/// body, or one of two dimensions, a tool is displayed at its pose in the physics.
constexpr std::int64_t most_cells = 200'000;

} // namespace

std::shared_ptr<const HandSurroundings> Physics::surround() const {
  const deform::World& world = timeline_.world();
  if (world.shape(grip_.object).n_voxels() > most_voxels)
    return nullptr;
  auto around = std::make_shared<HandSurroundings>();
  around->grip_number = grip_number_;
  for (int object = 0; object < world.n_objects(); ++object) {
    const Scene& scene = world.scene().objects[object].scene;
    if (world.kind(object) == ObjectKind::deformable &&
        (scene.dimension() < 3 || scene.specimen.grid.n_cells() > most_cells))
      return nullptr;
  }
  around->others = deform::surroundings_of(world, grip_.object);
  around->tool = std::make_shared<const deform::RigidShape>(world.shape(grip_.object));
  around->lattice = world.pose(grip_.object);
  around->frame = timeline_.drives().frame_now(world, static_cast<std::size_t>(grip_.object));
  return around;
}

void Physics::publish_surroundings() {
  surroundings_.publish(surround());
}

} // namespace maille::live
