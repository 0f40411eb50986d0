/// What a held object may run into, gathered for the loop at 1 kHz.

#include "session/physics.hpp"

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace maille::live {

namespace {

/// Tools of more voxels are too many for a loop at 1 kHz: they are shown where the physics has them.
constexpr std::int32_t most_voxels = 1500;
/// Surfaces of more faces take longer to gather than a frame. Beside such a body, or one of two dimensions, a
/// tool is shown where the physics has it.
constexpr std::int64_t most_cells = 200'000;

} // namespace

std::shared_ptr<const HandSurroundings> Physics::surround() const {
  const deform::World& world = timeline_.world();
  if (world.shape(grip_.object).n_voxels() > most_voxels)
    return nullptr;
  auto around = std::make_shared<HandSurroundings>();
  around->grip_number = grip_number_;
  auto others = std::make_shared<deform::RigidWorld>(world.map().cells(), world.cell_size());
  std::vector<std::shared_ptr<const deform::BodySurface>> bodies;
  for (int object = 0; object < world.n_objects(); ++object) {
    if (object == grip_.object)
      continue;
    if (world.kind(object) != ObjectKind::deformable) {
      others->add(world.shape(object), world.pose(object));
      continue;
    }
    const Scene& scene = world.scene().objects[object].scene;
    if (scene.dimension() < 3 || scene.specimen.grid.n_cells() > most_cells)
      return nullptr;
    bodies.push_back(
        std::make_shared<const deform::BodySurface>(scene, world.displacement(object), world.pose(object)));
  }
  around->matter = std::make_shared<const deform::Surroundings>(&others->map(), world.cell_size(), bodies);
  around->others = std::move(others);
  around->tool = std::make_shared<const deform::RigidShape>(world.shape(grip_.object));
  around->lattice = world.pose(grip_.object);
  around->frame = timeline_.drives().frame_now(world, static_cast<std::size_t>(grip_.object));
  return around;
}

void Physics::publish_surroundings() {
  surroundings_.publish(surround());
}

} // namespace maille::live
