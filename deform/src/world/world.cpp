#include "maille/deform/world/world.hpp"

#include "world/engine.hpp"
#include "world/occupancy/posed_shape.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace maille::deform {

World::World(WorldScene scene) : engine_(engine_for(std::move(scene))) {}
World::World(std::unique_ptr<Engine> engine) : engine_(std::move(engine)) {}
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;
World::~World() = default;

const WorldScene& World::scene() const {
  return engine_->world().scene;
}

const OccupancyMap& World::map() const {
  return engine_->world().map();
}

const Vec3& World::cell_size() const {
  return engine_->world().scene.spacing;
}

int World::n_objects() const {
  return engine_->world().n_objects();
}

ObjectKind World::kind(int object) const {
  return engine_->world().member(object).kind;
}

const RigidShape& World::shape(int object) const {
  return engine_->world().rigid.shape(engine_->world().member(object).index);
}

FrameResult World::advance(std::span<const Drive> drives, const FrameBudget& budget) {
  return engine_->advance(drives, budget);
}

void World::release(int object) {
  engine_->release(object);
}

void World::prepare(const FrameBudget& budget) {
  engine_->prepare(budget);
}

bool World::is_settled() const {
  return engine_->is_settled();
}

std::optional<World> World::copy() const {
  std::unique_ptr<Engine> copy = engine_->copy();
  return copy ? std::optional(World(std::move(copy))) : std::nullopt;
}

Scene World::question(int object) const {
  return engine_->question(object);
}

const Pose& World::pose(int object) const {
  return engine_->pose(object);
}

const Displacement& World::displacement(int object) const {
  return engine_->displacement(object);
}

std::shared_ptr<const Displacement> World::shared_displacement(int object) const {
  return engine_->shared_displacement(object);
}

Eigen::Vector3d World::position(int object, std::int64_t node) const {
  return engine_->position(object, node);
}

ObjectMotion World::motion(int object) const {
  return engine_->motion(object);
}

double World::energy() const {
  return engine_->energy();
}

double World::largest_violation() const {
  return engine_->largest_violation();
}

std::int64_t World::bytes() const {
  return engine_->bytes();
}

World::Occupant World::occupant(VoxelId id) const {
  const int object = engine_->world().object_of(id);
  return {object, engine_->world().voxel_of(object, id)};
}

std::vector<WorldContact> World::touched(int object, double reach) const {
  std::vector<WorldContact> list;
  const int index = engine_->world().member(object).index;
  engine_->world().map(); // updates the map
  for (const Contact& contact : engine_->world().rigid.touched(index, reach)) {
    const Occupant other = occupant(contact.other);
    list.push_back(
        {object, contact.voxel, other.object, other.voxel, contact.axis, contact.direction, {0, 0, 0}});
  }
  return list;
}

std::int64_t World::n_shared_cells() const {
  if (scene().is_open)
    return 0;
  OccupancyMap owners(engine_->world().rigid.map().cells()); // object numbers instead of voxel numbers
  std::int64_t n = 0;
  const auto look = [&](int object, const Index3& cell) {
    if (!owners.has_cell(cell) || (owners.is_occupied(cell) && owners.occupant(cell) != object))
      ++n;
    else
      owners.put(cell, object);
  };
  for (int object = 0; object < n_objects(); ++object) {
    if (engine_->world().is_body(object)) {
      const PosedLattice& lattice = engine_->world().body(object).lattice();
      for (std::int32_t voxel = 0; voxel < lattice.n_voxels(); ++voxel)
        look(object, cell_at(lattice.place(voxel, displacement(object))));
      continue;
    }
    any_voxel(PosedShape(shape(object), pose(object), cell_size()), 0, shape(object).n_voxels(),
              [&](std::int32_t, const Index3& cell) {
                look(object, cell);
                return false;
              });
  }
  return n;
}

} // namespace maille::deform
